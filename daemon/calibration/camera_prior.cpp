// SPDX-License-Identifier: Apache-2.0
#include "calibration/camera_prior.h"

#include <cmath>

namespace sslv {

CameraPrior camera_prior(int width_px, int height_px, const WholePicture& whole) {
  const int width = whole.width > 0 ? whole.width : width_px;
  const int height = whole.height > 0 ? whole.height : height_px;
  CameraPrior out;
  out.focal_px = 0.85 * width;
  out.center_x = (width - 1) / 2.0 - whole.x;
  out.center_y = (height - 1) / 2.0 - whole.y;
  out.center_sigma_px = 0.015 * width;
  return out;
}

CameraPrior with_second_radial(CameraPrior prior) {
  prior.k2_sigma = 0.3;
  return prior;
}

PriorRows prior_rows(const SteppedCamera& stepped, const CameraPrior& prior) {
  const LensCamera& camera = stepped.camera();
  const auto only = [](CameraParam param) {
    CameraStep out = CameraStep::Zero();
    out[param] = 1;
    return out;
  };
  PriorRows out;
  int row = 0;
  const auto add = [&](double off, const CameraStep& by_step, double sigma) {
    out.off[row] = off / sigma;
    out.by_step.row(row++) = by_step.transpose() / sigma;
  };
  add(std::log(camera.focal_px / prior.focal_px), only(kZoom), prior.focal_share);
  add(camera.center_x - prior.center_x, only(kCenterX), prior.center_sigma_px);
  add(camera.center_y - prior.center_y, only(kCenterY), prior.center_sigma_px);
  add(camera.k1 - prior.k1, stepped.k1_by_step(), prior.k1_sigma);
  add(camera.k2 - prior.k2, stepped.k2_by_step(), prior.k2_sigma);
  if (prior.height_mm)
    add(camera.position_mm.z() - *prior.height_mm, stepped.height_by_step(), prior.height_sigma_mm);
  return out;
}

}  // namespace sslv
