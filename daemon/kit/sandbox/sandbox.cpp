// SPDX-License-Identifier: Apache-2.0
#include "kit/sandbox/sandbox.h"

#include "base/params_json.h"
#include "base/plain_text.h"
#include "kit/load_stages.h"
#include "kit/read_stamp.h"
#include "kit/sandbox/ask_library.h"
#include "kit/sandbox/sandbox_step.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

using namespace sandbox;

/// Caches the complete parameters of one library's stages, so that unchanged parameters need no new process
/// to validate them.
class KnownParams {
 public:
  /// The complete parameters for a stage's parameters `json`, if cached.
  std::optional<Json> find(std::string_view floor, const std::string& stage, const Json& json) {
    const std::lock_guard lock(mutex_);
    const auto found = known_.find(key(floor, stage, json));
    if (found == known_.end()) return std::nullopt;
    return found->second;
  }
  void add(std::string_view floor, const std::string& stage, const Json& json, const Json& complete) {
    constexpr std::size_t kMost = 256;
    const std::lock_guard lock(mutex_);
    if (known_.size() >= kMost) known_.clear();
    known_.emplace(key(floor, stage, json), complete);
  }

 private:
  static std::string key(std::string_view floor, const std::string& stage, const Json& json) {
    return fmt::format("{} {} {}", floor, stage, json_text(json));
  }
  std::mutex mutex_;
  std::map<std::string, Json> known_;
};

/// Shared by all rows of one library and alive as long as any of them.
struct Library {
  std::string file;
  std::chrono::milliseconds checks_within;  // time limit of one validation of parameters
  KnownParams params;
  std::vector<std::unique_ptr<std::size_t>> places;  // places of own parts, one for each name
  std::vector<std::string> place_names;

  std::size_t* place_of(const std::string& name) {
    const auto found = std::ranges::find(place_names, name);
    if (found != place_names.end())
      return places[static_cast<std::size_t>(found - place_names.begin())].get();
    place_names.push_back(name);
    return places.emplace_back(std::make_unique<std::size_t>(0)).get();
  }
};

bool is_name(const std::string& text) {
  constexpr std::size_t kLongest = 60;
  return !text.empty() && text.size() <= kLongest && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

Json schema_with_deadline(Json schema) {
  const Json own = params_schema<DeadlineParams>();
  schema["properties"][kDeadlineKey] = own.at("properties").at(kDeadlineKey);
  return schema;
}

template <class Floor>
typename BasicStageType<Floor>::Parsed parse_apart(Library& library, const std::string& stage, Json json,
                                                   const std::string& path, const std::stop_token& stop) {
  static std::atomic<std::uint64_t> made{0};
  if (!json.is_object()) refuse(path, json, "an object of parameters");
  Json deadline = Json::object();
  if (json.contains(kDeadlineKey)) deadline[kDeadlineKey] = json.at(kDeadlineKey);
  json.erase(kDeadlineKey);
  auto params = std::make_shared<SandboxParams>();
  params->own = params_from_json<DeadlineParams>(deadline, path);
  params->id = ++made;

  std::optional<Json> complete = library.params.find(kFloorName<Floor>, stage, json);
  if (!complete) {
    try {
      Json answer = ask_library(
          library.file,
          {{"ask", "parse"}, {"floor", kFloorName<Floor>}, {"stage", stage}, {"json", json}, {"path", path}},
          stop, library.checks_within);
      complete = std::move(answer.at("complete"));
      if (!complete->is_object()) throw std::runtime_error("it gave invalid parameters");
    } catch (const std::exception& error) {
      const std::string what = error.what();
      throw SettingsError(what.starts_with(path) ? what : path + ": " + what);
    }
    library.params.add(kFloorName<Floor>, stage, json, *complete);
  }
  params->json = complete->dump();
  if (params->json.size() + sizeof(std::uint64_t) >
      kConstantRoom[static_cast<std::size_t>(Constant::kParams)])
    throw SettingsError(path + ": the parameters are too large for a stage in a process of its own");
  complete->update(params_to_json(params->own));
  return {std::move(params), std::move(*complete)};
}

template <class Floor>
BasicStageType<Floor> row_of(const Json& said, const std::shared_ptr<Library>& library,
                             Supervisor& supervisor) {
  const auto name = said.at("name").get<std::string>();
  if (!is_name(name)) throw std::runtime_error("has a stage with an invalid name");
  const auto fail = [&](const std::string& why) {
    throw std::runtime_error(
        fmt::format("stage '{}' cannot run in a process of its own: {}", name, escaped_text(why)));
  };
  StageNeeds needs{said.at("reads").get<std::uint64_t>(), said.at("writes").get<std::uint64_t>(),
                   said.at("updates").get<std::uint64_t>(), said.at("takes").get<std::uint32_t>()};
  if (((needs.reads | needs.writes | needs.updates) >> kPartCount<Floor>).any())
    fail("it uses unknown parts");
  if (const std::string why = why_not_apart<Floor>(needs); !why.empty()) fail(why);

  BasicStageType<Floor> row;
  row.name = name;
  row.help = shortened(plain_part(said.at("help").get<std::string>()), 500);
  row.reads = needs.reads;
  row.writes = needs.writes;
  row.updates = needs.updates;
  row.takes = needs.takes;
  row.library = escaped_text(std::filesystem::path(library->file).filename().string());
  std::vector<SandboxOwnPart> own_parts;
  for (const Json& part : said.at("own_parts")) {
    OwnPartUse use;
    use.type.name = part.at("name").get<std::string>();
    if (!is_name(use.type.name)) fail("it has a part with an invalid name");
    if (!part.at("is_encodable").get<bool>())
      fail(fmt::format("its part '{}' cannot be sent to another process (pipeline/part_codec.h)",
                       use.type.name));
    use.type.layout = part.at("layout").get<std::uint64_t>();
    use.type.code = FlatPart::code();
    use.is_written = part.at("is_written").get<bool>();
    use.is_updated = part.at("is_updated").get<bool>();
    use.place = library->place_of(use.type.name);
    own_parts.push_back({use.place, use.is_written, use.is_updated});
    row.own_parts.push_back(std::move(use));
  }
  const Json& schema = said.at("schema");
  if (!schema.is_object() || !schema.contains("properties") || !schema.at("properties").is_object())
    fail("its parameters are not described");
  if (schema.at("properties").contains(kDeadlineKey))
    fail(fmt::format("it has a parameter '{}', whose name is reserved", kDeadlineKey));
  const Json& defaults = said.at("defaults");
  if (!defaults.is_object()) fail("its parameters are not described");
  library->params.add(kFloorName<Floor>, name, Json::object(), defaults);
  row.schema = [full = schema_with_deadline(schema)] { return full; };
  row.create = [needs, own_parts, library, name, contract = contract_of(row),
                &supervisor]() -> std::unique_ptr<Step<Floor>> {
    return std::make_unique<SandboxStep<Floor>>(
        needs, own_parts, supervisor.start(name, library->file, std::string(kFloorName<Floor>), contract),
        supervisor.options().min_deadline);
  };
  row.parse = [library, name, stop = supervisor.stop()](const Json& json, const std::string& path) {
    return parse_apart<Floor>(*library, name, json, path, stop);
  };
  return row;
}

}  // namespace

StageRows sandboxed_rows(const std::string& library_file, Supervisor& supervisor,
                         std::chrono::milliseconds within) {
  try {
    auto library = std::make_shared<Library>();
    library->file = std::filesystem::absolute(library_file).string();
    library->checks_within = supervisor.options().starts_within;
    const Json described = ask_library(library->file, {{"ask", "describe"}}, supervisor.stop(), within);
    StageRows rows;
    for (const Json& one : described.at("camera"))
      rows.camera.push_back(row_of<CameraFloor>(one, library, supervisor));
    for (const Json& one : described.at("field"))
      rows.field.push_back(row_of<FieldFloor>(one, library, supervisor));
    return rows;
  } catch (const std::exception& error) {
    throw StageLibraryError(escaped_text(error.what()));
  }
}

}  // namespace sslv
