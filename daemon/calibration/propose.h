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

/// Cameras that an image's straight lines suggest, without clicks.
struct Proposal {
  std::vector<LensCamera> cameras;  // best score first; each to be refined and compared
  std::string problem;              // why there are no cameras
};

/// Estimates the distortion as the value that makes the lines straightest, finds straight lines in two
/// directions, and matches them to lines of the field.
Proposal propose_cameras(const LinePicture& picture, std::span<const PaintedCurve> curves,
                         const CameraPrior& prior, const std::stop_token& stop = {});

}  // namespace sslv
