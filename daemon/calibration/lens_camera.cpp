// SPDX-License-Identifier: Apache-2.0
#include "calibration/lens_camera.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace sslv {
namespace {

/// Smallest slope at which the distortion counts as one-to-one.
constexpr double kMinSlope = 0.05;

struct Distorted {
  double radius, slope;  // slope: d undistorted / d distorted
};

std::optional<Distorted> distort(double undistorted, double k1, double k2) {
  double r = undistorted;
  if (k1 * r * r > 1) r = std::cbrt(undistorted / k1);
  double slope = 1;
  for (int i = 0; i < 20; ++i) {
    const double r2 = r * r;
    slope = 1 + r2 * (3 * k1 + 5 * k2 * r2);
    if (slope < kMinSlope) return std::nullopt;
    const double step = (r * (1 + r2 * (k1 + k2 * r2)) - undistorted) / slope;
    r -= step;
    if (std::abs(step) < 1e-8) break;  // Newton's method: the remaining error is about its square
  }
  if (!std::isfinite(r)) return std::nullopt;
  return Distorted{r, slope};
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d out;
  out << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return out;
}

Eigen::Matrix3d rotation_by(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity() + cross_matrix(turn);
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

/// rotation_by(turn + d) = rotation_by(J d) rotation_by(turn) to first order.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  const Eigen::Matrix3d k = cross_matrix(turn);
  if (angle < 1e-6) return Eigen::Matrix3d::Identity() + 0.5 * k;
  const double a2 = angle * angle;
  return Eigen::Matrix3d::Identity() + (1 - std::cos(angle)) / a2 * k +
         (angle - std::sin(angle)) / (a2 * angle) * k * k;
}

/// Vector in mm to the camera from the point where its optical axis meets the floor, or from the floor below
/// the camera if the camera does not look down.
Eigen::Vector3d above_floor(const LensCamera& camera) {
  const Eigen::Vector3d axis = camera.rotation.row(2);
  if (axis.z() < -0.3) return axis * (camera.position_mm.z() / axis.z());
  return {0, 0, camera.position_mm.z()};
}

constexpr double kMmPerM = 1000;

}  // namespace

std::optional<Eigen::Vector2d> LensCamera::project(const Eigen::Vector3d& point_mm) const {
  const Eigen::Vector3d p = rotation * (point_mm - position_mm);
  if (!(p.z() > 0)) return std::nullopt;
  const Eigen::Vector2d u = p.head<2>() / p.z();
  const double radius = u.norm();
  const auto distorted = distort(radius, k1, k2);
  if (!distorted) return std::nullopt;
  const double scale = radius > 0 ? focal_px * distorted->radius / radius : focal_px;
  return Eigen::Vector2d(scale * u.x() + center_x, scale * u.y() + center_y);
}

std::optional<Eigen::Vector2d> LensCamera::unproject(const Eigen::Vector2d& pixel, double height_mm) const {
  const double x = (pixel.x() - center_x) / focal_px, y = (pixel.y() - center_y) / focal_px;
  const double r2 = x * x + y * y, scale = 1 + r2 * (k1 + k2 * r2);
  if (1 + r2 * (3 * k1 + 5 * k2 * r2) < kMinSlope) return std::nullopt;
  const Eigen::Vector3d ray = rotation.transpose() * Eigen::Vector3d(x * scale, y * scale, 1);
  const double along = (height_mm - position_mm.z()) / ray.z();
  if (!(along > 0) || !std::isfinite(along)) return std::nullopt;
  return Eigen::Vector2d(position_mm.head<2>() + along * ray.head<2>());
}

bool LensCamera::is_in_picture(const Eigen::Vector2d& pixel, double margin_px) const {
  return pixel.x() >= margin_px && pixel.y() >= margin_px && pixel.x() <= width - 1 - margin_px &&
         pixel.y() <= height - 1 - margin_px;
}

LensCamera lens_camera(const CameraCalibration& c) {
  LensCamera out;
  out.width = c.pixel_image_width;
  out.height = c.pixel_image_height;
  out.focal_px = c.focal_length;
  out.center_x = c.principal_point_x;
  out.center_y = c.principal_point_y;
  out.k1 = c.distortion;
  out.rotation = Eigen::Quaterniond(c.q3, c.q0, c.q1, c.q2).normalized().toRotationMatrix();
  out.position_mm = -out.rotation.transpose() * Eigen::Vector3d(c.tx, c.ty, c.tz);
  return out;
}

bool is_plausible(const LensCamera& camera) {
  const double width_mm = camera.width * camera.position_mm.z() / camera.focal_px;
  return camera.rotation(2, 2) < -0.5 && width_mm > 1500 && width_mm < 20000;
}

LensCamera moved(const LensCamera& camera, const CameraStep& step) {
  return SteppedCamera(camera, step).camera();
}

SteppedCamera::SteppedCamera(const LensCamera& start, const CameraStep& step)
    : start_(start), camera_(start), grow_(std::exp(step[kZoom])) {
  const Eigen::Vector3d turn = step.segment<3>(kTurnX);
  const Eigen::Vector3d above_mm = above_floor(start);
  camera_.focal_px *= grow_;
  camera_.center_x += step[kCenterX];
  camera_.center_y += step[kCenterY];
  camera_.k1 = start.k1 * std::pow(grow_, 2) + step[kK1];
  camera_.k2 = start.k2 * std::pow(grow_, 4) + step[kK2];
  camera_.rotation = rotation_by(turn) * start.rotation;
  camera_.position_mm += (grow_ - 1) * above_mm + kMmPerM * step.segment<3>(kMoveX);
  along_axis_mm_ = grow_ * above_mm;
  turn_by_step_ = left_jacobian(turn);
}

std::optional<SteppedPixel> SteppedCamera::project(const Eigen::Vector3d& point_mm) const {
  const LensCamera& c = camera_;
  const Eigen::Vector3d p = c.rotation * (point_mm - c.position_mm);
  if (!(p.z() > 0)) return std::nullopt;
  const Eigen::Vector2d u = p.head<2>() / p.z();
  const double radius = u.norm();
  const auto distorted = distort(radius, c.k1, c.k2);
  if (!distorted) return std::nullopt;
  const double r = distorted->radius, slope = distorted->slope;
  const bool off_axis = radius > 1e-12;
  const Eigen::Vector2d direction = off_axis ? Eigen::Vector2d(u / radius) : Eigen::Vector2d(0, 0);
  const double scale = off_axis ? r / radius : 1;
  const Eigen::Vector2d d = scale * u;

  SteppedPixel out;
  out.pixel = c.focal_px * d + Eigen::Vector2d(c.center_x, c.center_y);
  Eigen::Matrix2d d_by_u = scale * Eigen::Matrix2d::Identity();
  if (off_axis) d_by_u += (1 / slope - scale) * direction * direction.transpose();
  Eigen::Matrix<double, 2, 3> u_by_p;
  u_by_p << 1 / p.z(), 0, -u.x() / p.z(), 0, 1 / p.z(), -u.y() / p.z();
  const Eigen::Matrix<double, 2, 3> by_p = c.focal_px * d_by_u * u_by_p;
  const Eigen::Matrix<double, 2, 3> by_position = -by_p * c.rotation;
  const Eigen::Vector2d by_k1 = -c.focal_px * r * r * r / slope * direction;
  const Eigen::Vector2d by_k2 = r * r * by_k1;

  out.by_step.col(kZoom) =
      c.focal_px * d + by_k1 * k1_by_zoom() + by_k2 * k2_by_zoom() + by_position * along_axis_mm_;
  out.by_step.col(kCenterX) = Eigen::Vector2d::UnitX();
  out.by_step.col(kCenterY) = Eigen::Vector2d::UnitY();
  out.by_step.col(kK1) = by_k1;
  out.by_step.col(kK2) = by_k2;
  out.by_step.middleCols<3>(kTurnX) = -by_p * cross_matrix(p) * turn_by_step_;
  out.by_step.middleCols<3>(kMoveX) = kMmPerM * by_position;
  return out;
}

CameraStep SteppedCamera::height_by_step() const {
  CameraStep out = CameraStep::Zero();
  out[kZoom] = along_axis_mm_.z();
  out[kMoveZ] = kMmPerM;
  return out;
}

double SteppedCamera::k1_by_zoom() const {
  return 2 * start_.k1 * grow_ * grow_;
}

double SteppedCamera::k2_by_zoom() const {
  return 4 * start_.k2 * grow_ * grow_ * grow_ * grow_;
}

CameraStep SteppedCamera::k1_by_step() const {
  CameraStep out = CameraStep::Zero();
  out[kZoom] = k1_by_zoom();
  out[kK1] = 1;
  return out;
}

CameraStep SteppedCamera::k2_by_step() const {
  CameraStep out = CameraStep::Zero();
  out[kZoom] = k2_by_zoom();
  out[kK2] = 1;
  return out;
}

}  // namespace sslv
