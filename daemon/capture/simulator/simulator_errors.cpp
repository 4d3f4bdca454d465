// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_errors.h"

#include <numbers>

#include <Eigen/Geometry>

namespace sslv {

CameraModel with_errors(const CameraModel& calibrated, const SimulatorErrors& errors) {
  if (errors.moved_x_mm == 0 && errors.moved_y_mm == 0 && errors.turned_deg == 0) return calibrated;
  CameraCalibration out = calibrated.calibration();
  const Eigen::Quaterniond before(out.q3, out.q0, out.q1, out.q2);
  const Eigen::AngleAxisd turned(-errors.turned_deg * std::numbers::pi / 180, Eigen::Vector3d::UnitZ());
  const Eigen::Quaterniond now = (before * turned).normalized();
  const Eigen::Vector3d place =
      calibrated.position_mm() + Eigen::Vector3d(errors.moved_x_mm, errors.moved_y_mm, 0);
  const Eigen::Vector3d t = -(now * place);
  out.q0 = now.x();
  out.q1 = now.y();
  out.q2 = now.z();
  out.q3 = now.w();
  out.tx = t.x();
  out.ty = t.y();
  out.tz = t.z();
  return CameraModel(out);
}

}  // namespace sslv
