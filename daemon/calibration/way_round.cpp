// SPDX-License-Identifier: Apache-2.0
#include "calibration/way_round.h"

#include <cmath>

namespace sslv {
namespace {

/// Direction of +x in the image, of length 1.
Eigen::Vector2d plus_x_of(const LensCamera& camera) {
  const Eigen::Vector2d x = camera.rotation.col(0).head<2>();
  return x.norm() > 0 ? Eigen::Vector2d(x.normalized()) : x;
}

Eigen::Vector2d direction_of(PlusX side) {
  switch (side) {
    case PlusX::kRight: return {1, 0};
    case PlusX::kLeft: return {-1, 0};
    case PlusX::kUp: return {0, -1};
    case PlusX::kDown: return {0, 1};
    case PlusX::kUnknown: break;
  }
  return {0, 0};
}

}  // namespace

bool same_way_round(const LensCamera& a, const LensCamera& b) {
  return (a.rotation * b.rotation.transpose()).trace() > 2;
}

bool is_right_way_round(const LensCamera& camera, const CalibrationTask& task) {
  const Eigen::Vector2d x = plus_x_of(camera);
  if (task.plus_x != PlusX::kUnknown) return x.dot(direction_of(task.plus_x)) > 0;
  if (task.previous) return same_way_round(camera, lens_camera(*task.previous));
  return std::abs(x.x()) > std::abs(x.y()) ? x.x() > 0 : x.y() < 0;
}

LensCamera turned_round(const LensCamera& camera) {
  const Eigen::DiagonalMatrix<double, 3> turn(-1, -1, 1);
  LensCamera out = camera;
  out.rotation = camera.rotation * turn;
  out.position_mm = turn * camera.position_mm;
  return out;
}

const char* side_of_plus_x(const LensCamera& camera) {
  const Eigen::Vector2d x = plus_x_of(camera);
  if (std::abs(x.x()) > std::abs(x.y())) return x.x() > 0 ? "right" : "left";
  return x.y() > 0 ? "bottom" : "top";
}

}  // namespace sslv
