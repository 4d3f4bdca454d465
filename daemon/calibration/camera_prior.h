// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "image/frame_info.h"

#include <optional>

#include <Eigen/Core>

namespace sslv {

/// Knowledge about a camera before its image is used: expected values and standard deviations.
struct CameraPrior {
  double focal_px = 0, focal_share = 0.4;  // focal_share: standard deviation, as a share of the focal length
  double center_x = 0, center_y = 0, center_sigma_px = 1;
  double k1 = 0.1, k1_sigma = 0.2;
  double k2 = 0, k2_sigma = 1e-9;
  std::optional<double> height_mm;  // height of the camera above the floor
  double height_sigma_mm = 1;
};

/// Prior for an image of this size if nothing else is known. Lenses used over fields have focal lengths of
/// 0.5 to 1.3 widths of the whole image and their principal point near its centre.
CameraPrior camera_prior(int width_px, int height_px, const WholePicture& whole = {});

/// The same prior, but with the second radial term k2 free to be fitted.
CameraPrior with_second_radial(CameraPrior prior);

/// Residuals of a camera against its prior, in sigmas, and their Jacobian with respect to the step parameters
/// (one row each).
struct PriorRows {
  static constexpr int kCount = 6;
  Eigen::Matrix<double, kCount, 1> off = Eigen::Matrix<double, kCount, 1>::Zero();
  Eigen::Matrix<double, kCount, kCameraParams> by_step = Eigen::Matrix<double, kCount, kCameraParams>::Zero();
};
PriorRows prior_rows(const SteppedCamera& stepped, const CameraPrior& prior);

}  // namespace sslv
