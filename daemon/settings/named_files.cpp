// SPDX-License-Identifier: Apache-2.0
#include "settings/named_files.h"

#include "base/error.h"

#include <algorithm>
#include <set>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sslv {
namespace {

void collect(const Json& schema, const Json& value, const std::string& path, std::vector<NamedFile>& out) {
  if (!schema.is_object()) return;
  if (value.is_string() && schema.value("format", "") == "file") {
    if (const auto& text = value.get_ref<const std::string&>(); !text.empty()) out.push_back({path, text});
  } else if (value.is_object()) {
    if (const auto properties = schema.find("properties"); properties != schema.end()) {
      for (const auto& [key, one] : value.items()) {
        if (properties->contains(key)) collect(properties->at(key), one, path + "/" + key, out);
      }
    }
    // Among a source's alternatives, use the alternative of its backend.
    for (const Json& one : schema.value("oneOf", Json::array())) {
      const Json::json_pointer backend("/properties/backend/const");
      if (one.contains(backend) && value.contains("backend") && one.at(backend) == value["backend"])
        collect(one, value, path, out);
    }
  } else if (value.is_array() && schema.contains("items")) {
    for (std::size_t i = 0; i < value.size(); ++i)
      collect(schema["items"], value[i], path + "/" + std::to_string(i), out);
  }
}

}  // namespace

bool lies_in(const std::filesystem::path& file, const std::filesystem::path& folder) {
  std::error_code error;
  const auto real_file = std::filesystem::weakly_canonical(file, error);
  if (error) return false;
  const auto real_folder = std::filesystem::weakly_canonical(folder, error);
  if (error) return false;
  const auto [end, ignored] =
      std::mismatch(real_folder.begin(), real_folder.end(), real_file.begin(), real_file.end());
  return end == real_folder.end();
}

std::vector<NamedFile> named_files(const Json& schema, const Json& settings) {
  std::vector<NamedFile> out;
  collect(schema, settings, "", out);
  return out;
}

void check_named_files(const Json& schema, const Json& next, const std::vector<Json>& known,
                       const std::vector<std::filesystem::path>& folders) {
  std::set<std::filesystem::path> known_files;
  for (const Json& tree : known) {
    for (const NamedFile& one : named_files(schema, tree)) known_files.insert(one.file);
  }
  for (const NamedFile& one : named_files(schema, next)) {
    const auto is_in = [&](const auto& folder) { return lies_in(one.file, folder); };
    if (known_files.contains(one.file) || std::any_of(folders.begin(), folders.end(), is_in)) continue;
    std::vector<std::string> names;
    for (const auto& folder : folders) names.push_back(folder.string());
    throw SettingsError(
        fmt::format("{}: \"{}\" is not allowed here; expected a file in {}; other files can be named in the "
                    "settings file, or their folder allowed with --files",
                    one.path, one.file.string(), fmt::join(names, ", ")));
  }
}

}  // namespace sslv
