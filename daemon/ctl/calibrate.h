// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "ctl/client.h"

#include <optional>
#include <string>

namespace sslv {

/// Command-line options that complete or override a file of points; none: not given.
struct CalibrateWords {
  std::string points_file;
  std::optional<int> frames;
  std::optional<double> height_mm, height_sigma_mm, focal_px;
  std::string plus_x, lines;  // as on the command line; empty: not given
};

/// Returns the request as JSON, not yet checked. Throws SettingsError if the file is no JSON.
Json calibration_request(const CalibrateWords& words);

/// Has a running daemon calibrate a camera and returns the report. Throws ClientError if that is refused,
/// fails or is cancelled.
Json calibrate_running(const Client& daemon, int camera_id, const Json& request);

/// The same for several cameras together.
Json calibrate_together(const Client& daemon, const Json& request);

/// Reports of docs/openapi.json for a terminal.
std::string calibration_text(const Json& report);
std::string joint_calibration_text(const Json& report);

}  // namespace sslv
