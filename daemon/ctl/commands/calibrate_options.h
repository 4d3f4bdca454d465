// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ctl/calibrate.h"

#include <string>

#include <CLI/CLI.hpp>

namespace sslv {

/// Options of `calibrate` in ssl-visionctl, for the daemon's cameras, and in ssl-visionlab, for files.
struct CalibrateOptions {
  CalibrateWords words;
  std::string calibration_file, report_file;
  bool as_json = false;

  void add_to(CLI::App* command);
  /// Writes the result: the calibration, if found, and the whole report to the files, and human-readable text
  /// to the terminal. Returns the exit code.
  int tell(const Json& report, std::string (*text)(const Json&)) const;
};

}  // namespace sslv
