// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/fit_camera.h"
#include "calibration/line_picture.h"
#include "calibration/painted_curves.h"

#include <span>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

/// Cameras that an image's straight lines suggest, with nobody pointing at anything.
struct Proposal {
  std::vector<LensCamera> cameras;  // most promising first; each to be refined and compared
  std::string problem;              // why there are none
};

/// Finds straight lines in two directions and tries which lines of the field they may be. Distortion is found
/// first, as that with which lines are straightest.
Proposal propose_cameras(const LinePicture& picture, std::span<const PaintedCurve> curves,
                         const CameraPrior& prior, const std::stop_token& stop = {});

}  // namespace sslv
