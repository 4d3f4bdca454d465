// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "calibration/calibrate.h"
#include "calibration/calibration_json.h"
#include "ctl/client.h"

#include <iosfwd>
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

/// Returns the request as validated JSON. Throws SettingsError.
Json calibration_request(const CalibrateWords& words);

struct CalibrateInput {
  std::string path, pixel_format;
  int width = 0, height = 0;  // size of raw frames
};

/// Calibrates from recorded images. Images that cannot be read are listed on `problems`. Throws
/// SettingsError, and CaptureError if no image can be used.
CalibrationReport calibrate_recording(const CalibrateInput& input, const CalibrationRequest& request,
                                      const FieldSize& field, std::optional<CameraCalibration> previous,
                                      std::ostream& problems);

/// Returns the field of a preset or of a settings file. Throws SettingsError.
FieldSize field_named(const std::string& name_or_file);

/// Reads a calibration in the format of the settings. Throws SettingsError.
CameraCalibration read_calibration(const std::string& file);

/// Has a running daemon calibrate a camera and returns the report. Throws ClientError if that is refused,
/// fails or is cancelled.
Json calibrate_running(const Client& daemon, int camera_id, const Json& request);

/// The same for several cameras together.
Json calibrate_together(const Client& daemon, const Json& request);

/// Reports of docs/openapi.json for a terminal.
std::string calibration_text(const Json& report);
std::string joint_calibration_text(const Json& report);

}  // namespace sslv
