// SPDX-License-Identifier: Apache-2.0
#include "geometry/camera_model.h"

#include "base/error.h"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sslv {
namespace {

/// Solves ru = rd (1 + d rd^2) for rd in [0, rd_max], in which the right side grows monotonically.
double distort(double undistorted, double d, double rd_max) {
  if (d == 0 || undistorted == 0) return undistorted;
  double low = 0, high = d > 0 ? undistorted : rd_max;
  double rd = std::min(undistorted, high);
  // Newton's method kept inside a shrinking bracket; quadratic near the root, so few iterations are needed.
  for (int i = 0; i < 60; ++i) {
    const double error = rd * (1 + d * rd * rd) - undistorted;
    (error > 0 ? high : low) = rd;
    const double slope = 1 + 3 * d * rd * rd;
    double next = slope > 0 ? rd - error / slope : low;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    if (std::abs(next - rd) <= 1e-15 * (1 + rd)) return next;
    rd = next;
  }
  return rd;
}

}  // namespace

CameraModel::CameraModel(const CameraCalibration& calibration, const std::string& path)
    : calibration_(calibration) {
  const auto& c = calibration_;
  const Eigen::Quaterniond q(c.q3, c.q0, c.q1, c.q2);
  if (!(std::abs(q.norm() - 1) < 1e-3)) {
    throw SettingsError(fmt::format("{}: q0..q3 has length {:.6g}; a rotation needs a quaternion of length 1",
                                    path, q.norm()));
  }
  rotation_ = q.normalized().toRotationMatrix();
  translation_mm_ = {c.tx, c.ty, c.tz};
  position_mm_ = -rotation_.transpose() * translation_mm_;

  max_distorted_radius_ =
      c.distortion < 0 ? 1 / std::sqrt(-3 * c.distortion) : std::numeric_limits<double>::infinity();
  if (c.pixel_image_width > 0 && c.pixel_image_height > 0) {
    const double dx = std::max(c.principal_point_x + 0.5, c.pixel_image_width - 0.5 - c.principal_point_x);
    const double dy = std::max(c.principal_point_y + 0.5, c.pixel_image_height - 0.5 - c.principal_point_y);
    const double corner = std::hypot(dx, dy) / c.focal_length;
    if (corner >= max_distorted_radius_) {
      throw SettingsError(
          fmt::format("{}/distortion: {} is not allowed; expected more than {:.4g}, below which pixels and "
                      "rays do not match one to one in the image's corners",
                      path, c.distortion, -1 / (3 * corner * corner)));
    }
  }
}

std::optional<Eigen::Vector2d> CameraModel::project(const Eigen::Vector3d& point_mm) const {
  const Eigen::Vector3d p = rotation_ * point_mm + translation_mm_;
  if (p.z() <= 0) return std::nullopt;
  const Eigen::Vector2d u = p.head<2>() / p.z();
  const double ru = u.norm();
  const double d = calibration_.distortion;
  if (std::isfinite(max_distorted_radius_) &&
      ru > max_distorted_radius_ * (1 + d * max_distorted_radius_ * max_distorted_radius_)) {
    return std::nullopt;
  }
  const double scale = ru > 0 ? distort(ru, d, max_distorted_radius_) / ru : 1.0;
  return Eigen::Vector2d(calibration_.focal_length * scale * u.x() + calibration_.principal_point_x,
                         calibration_.focal_length * scale * u.y() + calibration_.principal_point_y);
}

std::optional<Eigen::Vector3d> CameraModel::ray(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - calibration_.principal_point_x) / calibration_.focal_length,
                                  (pixel.y() - calibration_.principal_point_y) / calibration_.focal_length);
  const double r2 = distorted.squaredNorm();
  if (r2 > max_distorted_radius_ * max_distorted_radius_) return std::nullopt;
  const double scale = 1 + calibration_.distortion * r2;
  return rotation_.transpose() * Eigen::Vector3d(distorted.x() * scale, distorted.y() * scale, 1);
}

std::optional<Eigen::Vector2d> CameraModel::unproject(const Eigen::Vector2d& pixel, double height_mm) const {
  const auto direction = ray(pixel);
  if (!direction) return std::nullopt;
  const double along = (height_mm - position_mm_.z()) / direction->z();
  if (!(along > 0) || !std::isfinite(along)) return std::nullopt;
  return Eigen::Vector2d(position_mm_.x() + along * direction->x(),
                         position_mm_.y() + along * direction->y());
}

double CameraModel::mm2_per_px(const Eigen::Vector2d& pixel, double height_mm) const {
  const auto direction = ray(pixel);
  if (!direction) return 0;
  const double along = (height_mm - position_mm_.z()) / direction->z();
  if (!(along > 0) || !std::isfinite(along)) return 0;
  // Undistortion scales areas by (1 + d r^2)(1 + 3 d r^2). A unit area of the undistorted image covers
  // along^2 / |direction z| of the plane, because its rays have length 1 along the optical axis.
  const double f = calibration_.focal_length, d = calibration_.distortion;
  const double x = (pixel.x() - calibration_.principal_point_x) / f,
               y = (pixel.y() - calibration_.principal_point_y) / f, r2 = x * x + y * y;
  return along * along / std::abs(direction->z()) * (1 + d * r2) * (1 + 3 * d * r2) / (f * f);
}

}  // namespace sslv
