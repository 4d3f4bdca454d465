// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/health_report.h"

#include <string>

namespace sslv {

/// What is wrong with the settings and the folder that keeps them; empty where nothing is.
struct SettingsFacts {
  std::string start_problem;   // with what was saved, at start
  std::string save_problem;    // why the last file was not saved
  std::string folder_problem;  // why none can be saved now
  std::string reload_problem;  // why the settings file was not taken over
};

/// Adds their alerts, which belong to the check "computer".
void report_settings(const SettingsFacts& facts, HealthReport& report);

}  // namespace sslv
