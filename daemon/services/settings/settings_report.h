// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/health_report.h"

#include <string>

namespace sslv {

/// Problems of the settings and of their folder; empty: none.
struct SettingsFacts {
  std::string start_problem;   // problem with the saved changes at start
  std::string save_problem;    // why the last file was not saved
  std::string folder_problem;  // why nothing can be saved at present
  std::string reload_problem;  // why the settings file was not reloaded
};

/// Adds alerts for these problems; the alerts belong to the check "computer".
void report_settings(const SettingsFacts& facts, HealthReport& report);

}  // namespace sslv
