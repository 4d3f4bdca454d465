// SPDX-License-Identifier: Apache-2.0
#include "config/missing_stages.h"

#include "base/error.h"
#include "base/plain_text.h"

#include <algorithm>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

/// 'a', 'b' and 'c'.
std::string quoted_list(const std::vector<std::string>& names) {
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string_view before = i == 0 ? "" : i + 1 < names.size() ? ", " : " and ";
    out += fmt::format("{}'{}'", before, shortened(names[i]));
  }
  return out;
}

std::string listed(std::string_view before, const std::vector<std::string>& names) {
  return fmt::format("{} stage{} {}", before, names.size() == 1 ? "" : "s", quoted_list(names));
}

/// Whether a stack of the settings names the stage, or the settings have parameters for it.
bool is_named(const Config& config, const std::string& name) {
  const auto has = [&](const auto& part) {
    return std::ranges::find(part.stack, name) != part.stack.end() || part.stages.contains(name);
  };
  return has(config.field) ||
         std::ranges::any_of(config.cameras, [&](const CameraSettings& camera) { return has(camera); });
}

/// Whether a stage refuses parameters of the settings for the reason `why`, which contains the parameters'
/// path.
bool is_refused(const Config& config, const std::string& why) {
  const auto has = [&](const RunningStack& running) {
    return std::ranges::find(running.refused, why, &RefusedStage::why) != running.refused.end();
  };
  return has(config.field.running) || std::ranges::any_of(config.cameras, [&](const CameraSettings& camera) {
           return has(camera.running);
         });
}

}  // namespace

std::string missing_text(const RunningStack& running) {
  std::string out;
  if (!running.missing.empty()) {
    out = fmt::format("{}, which {} not installed", listed("without the", running.missing),
                      running.missing.size() == 1 ? "is" : "are");
  }
  for (const RefusedStage& stage : running.refused) {
    out += fmt::format("{}without the stage '{}', whose parameters are for another version ({})",
                       out.empty() ? "" : "; ", stage.name, stage.why);
  }
  if (!running.idle.empty()) {
    const bool is_one = running.idle.size() == 1;
    out += fmt::format("; {} depend{} on a stage that does not run, and do{} not run either",
                       quoted_list(running.idle), is_one ? "s" : "", is_one ? "es" : "");
  }
  return out;
}

std::string missing_fix(const RunningStack& running) {
  std::string out;
  for (const LeftOutLibrary& one : left_out_libraries())
    out +=
        fmt::format("{}{} {}", out.empty() ? "" : "; ", escaped_text(one.file.filename().string()), one.why);
  if (running.missing.empty()) {
    out = "Correct the parameters, or remove the stage from the stack.";
  } else {
    const bool is_one = running.missing.size() == 1;
    if (out.empty()) out = fmt::format("No stage library provides {}", is_one ? "it" : "them");
    out += fmt::format(
        ". Install a matching library and restart the service, or remove the stage{} from the stack.",
        is_one ? "" : "s");
  }
  return out;
}

void refuse_new_missing(const Config& now, const Config& next) {
  const auto check = [&now](const std::string& name, const std::string& path) {
    if (is_named(now, name)) return;
    throw SettingsError(fmt::format("{}: the stage '{}' is not installed", path, shortened(name)));
  };
  const auto check_part = [&](const auto& part, auto table, const std::string& path) {
    for (const std::string& name : part.running.missing) check(name, path + "/stack");
    for (const auto& item : part.stages.items()) {
      if (std::ranges::none_of(table, [&](const auto& type) { return type.name == item.key(); }))
        check(item.key(), path + "/stages");
    }
    for (const RefusedStage& stage : part.running.refused)
      if (!is_refused(now, stage.why)) throw SettingsError(stage.why);
  };
  check_part(next.field, field_stage_table(), "/field");
  for (std::size_t i = 0; i < next.cameras.size(); ++i)
    check_part(next.cameras[i], stage_table(), fmt::format("/cameras/{}", i));
}

}  // namespace sslv
