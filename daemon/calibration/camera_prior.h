// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "image/frame_info.h"

#include <optional>

#include <Eigen/Core>

namespace sslv {

/// What is known of a camera without looking: expected values and their standard deviations.
struct CameraPrior {
  double focal_px = 0, focal_share = 0.4;  // the deviation as a share of the focal length
  double center_x = 0, center_y = 0, center_sigma_px = 1;
  double k1 = 0.1, k1_sigma = 0.2;
  double k2 = 0, k2_sigma = 1e-9;
  std::optional<double> height_mm;  // of the camera above the floor
  double height_sigma_mm = 1;
};

/// For an image of this size, of which nothing else is known: lenses on fields have .5 to 1.3 widths of the
/// whole image, and look through its middle.
CameraPrior camera_prior(int width_px, int height_px, const WholePicture& whole = {});

/// The same for a lens that may bend more than one radial term says.
CameraPrior with_second_radial(CameraPrior prior);

/// How far a camera is from what is known of it, in sigmas, and how that changes with its parameters (rows).
struct PriorRows {
  static constexpr int kCount = 6;
  Eigen::Matrix<double, kCount, 1> off = Eigen::Matrix<double, kCount, 1>::Zero();
  Eigen::Matrix<double, kCount, kCameraParams> by_step = Eigen::Matrix<double, kCount, kCameraParams>::Zero();
};
PriorRows prior_rows(const SteppedCamera& stepped, const CameraPrior& prior);

}  // namespace sslv
