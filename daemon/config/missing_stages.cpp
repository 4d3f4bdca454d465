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

/// Whether a stack of it names the stage, or it has parameters of it.
bool is_named(const Config& config, const std::string& name) {
  const auto has = [&](const auto& part) {
    return std::ranges::find(part.stack, name) != part.stack.end() || part.stages.contains(name);
  };
  return has(config.field) ||
         std::ranges::any_of(config.cameras, [&](const CameraSettings& camera) { return has(camera); });
}

}  // namespace

std::string missing_text(const RunningStack& running) {
  if (running.missing.empty()) return {};
  const bool is_one = running.missing.size() == 1;
  std::string out =
      fmt::format("{}, which {} not there", listed("without the", running.missing), is_one ? "is" : "are");
  if (!running.idle.empty()) {
    out += fmt::format("; {} need{} {} and do{} not run either", quoted_list(running.idle),
                       running.idle.size() == 1 ? "s" : "", is_one ? "it" : "them",
                       running.idle.size() == 1 ? "es" : "");
  }
  return out;
}

std::string missing_fix() {
  std::string out;
  for (const LeftOutLibrary& one : left_out_libraries())
    out +=
        fmt::format("{}{} {}", out.empty() ? "" : "; ", escaped_text(one.file.filename().string()), one.why);
  if (out.empty()) out = "No library in the folders of stages brings it";
  return out + ". Install it and restart the service, or take it out of the stack.";
}

void refuse_new_missing(const Config& now, const Config& next) {
  const auto check = [&now](const std::string& name, const std::string& path) {
    if (is_named(now, name)) return;
    throw SettingsError(fmt::format("{}: the stage '{}' is not there", path, shortened(name)));
  };
  const auto check_part = [&check](const auto& part, auto table, const std::string& path) {
    for (const std::string& name : part.running.missing) check(name, path + "/stack");
    for (const auto& item : part.stages.items()) {
      if (std::ranges::none_of(table, [&](const auto& type) { return type.name == item.key(); }))
        check(item.key(), path + "/stages");
    }
  };
  check_part(next.field, field_stage_table(), "/field");
  for (std::size_t i = 0; i < next.cameras.size(); ++i)
    check_part(next.cameras[i], stage_table(), fmt::format("/cameras/{}", i));
}

}  // namespace sslv
