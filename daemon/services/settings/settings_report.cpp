// SPDX-License-Identifier: Apache-2.0
#include "services/settings/settings_report.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {

void report_settings(const SettingsFacts& facts, HealthReport& report) {
  const auto warn = [&](const char* id, std::string title, std::string fix, const char* page) {
    report.alerts.push_back({.id = id,
                             .check = "computer",
                             .severity = Severity::kWarn,
                             .title = std::move(title),
                             .fix = std::move(fix),
                             .page = page});
  };
  if (!facts.start_problem.empty()) {
    warn("settings_rejected", facts.start_problem, "Check the settings and save what is missing again.",
         "#/settings");
  }
  if (!facts.save_problem.empty()) {
    warn("settings_not_saved",
         fmt::format("The last change was refused, as it could not be saved: {}", facts.save_problem),
         "Free disk space or fix the folder's permissions, then make the change again.", "#/settings");
  }
  if (!facts.folder_problem.empty()) {
    warn("state_not_writable", fmt::format("No change can be saved: {}", facts.folder_problem),
         "Fix the folder's permissions, or mount its disk for writing. Everything else keeps running.",
         "#/diagnostics");
  }
  if (!facts.reload_problem.empty()) {
    warn("settings_not_reloaded",
         fmt::format("The settings file was not loaded, the previous settings stay in effect: {}",
                     facts.reload_problem),
         "Fix the file, then reload: systemctl reload ssl-visiond", "#/settings");
  }
}

}  // namespace sslv
