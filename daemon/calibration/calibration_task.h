// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/clicks.h"
#include "calibration/painted_curves.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace sslv {

/// Where the +x half of the field lies in the image. Asked for when both halves look alike.
enum class PlusX : std::uint8_t { kUnknown, kRight, kLeft, kUp, kDown };

struct CalibrationTask {
  FieldSize field;
  std::optional<LinesMeasured> measured;  // none: see choose_model()
  /// Any four or more, in any order: names only say which points were meant. None: the corners are looked
  /// for.
  std::vector<ClickedPoint> clicks;
  double click_sigma_px = 3;
  PlusX plus_x = PlusX::kUnknown;
  std::optional<double> height_mm;  // of the camera, measured to
  double height_sigma_mm = 20;
  std::optional<double> focal_px;  // of the lens, known to
  double focal_share = 0.02;
  std::optional<CameraCalibration> previous;  // to compare with
};

}  // namespace sslv
