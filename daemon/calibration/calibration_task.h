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

/// Side of the image where the +x half of the field lies. Needed when both halves look alike.
enum class PlusX : std::uint8_t { kUnknown, kRight, kLeft, kUp, kDown };

struct CalibrationTask {
  FieldSize field;
  std::optional<LinesMeasured> measured;  // none: choose_model() decides
  /// Three or more clicks, in any order; a name states only the intended point. Empty: propose_cameras()
  /// starts from the straight lines in the image.
  std::vector<ClickedPoint> clicks;
  double click_sigma_px = 3;
  PlusX plus_x = PlusX::kUnknown;
  std::optional<double> height_mm;  // height of the camera above the floor, if measured
  double height_sigma_mm = 20;
  std::optional<double> focal_px;             // focal length of the lens, if known
  double focal_share = 0.02;                  // standard deviation, as a share of focal_px
  std::optional<CameraCalibration> previous;  // for comparison, and to distinguish the field's ends
};

}  // namespace sslv
