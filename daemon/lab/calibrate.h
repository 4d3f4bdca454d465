// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/calibrate.h"
#include "calibration/calibration_json.h"
#include "ctl/calibrate.h"

#include <iosfwd>
#include <optional>
#include <string>

namespace sslv {

/// Throws SettingsError, which names the file of points if the mistake is there.
CalibrationRequest checked_request(const CalibrateWords& words);

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

}  // namespace sslv
