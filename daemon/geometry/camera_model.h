// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <optional>
#include <string>
#include <tuple>

#include <Eigen/Core>

namespace sslv {

/// A camera's calibration with the names, units and convention of SSL_GeometryCameraCalibration:
/// q = (x, y, z, w) rotates field to camera, t is in mm in the camera's frame, and the camera looks along +z.
struct CameraCalibration {
  double focal_length = 600;  // px
  double principal_point_x = 0, principal_point_y = 0;
  double distortion = 0;
  double q0 = 0, q1 = 0, q2 = 0, q3 = 1;
  double tx = 0, ty = 0, tz = 0;
  int pixel_image_width = 0, pixel_image_height = 0;  // size of the image for which the calibration was made

  bool operator==(const CameraCalibration&) const = default;
  static constexpr auto fields() {
    using C = CameraCalibration;
    return std::tuple{
        number("focal_length", &C::focal_length, 1.0, 1e6, "px", "focal length"),
        number("principal_point_x", &C::principal_point_x, -1e5, 1e5, "px",
               "where the optical axis meets the image"),
        number("principal_point_y", &C::principal_point_y, -1e5, 1e5, "px",
               "where the optical axis meets the image"),
        number("distortion", &C::distortion, -10.0, 10.0, "",
               "radial: undistorted = distorted (1 + d distorted^2)"),
        number("q0", &C::q0, -1.001, 1.001, "", "rotation field to camera, x of the unit quaternion"),
        number("q1", &C::q1, -1.001, 1.001, "", "rotation field to camera, y"),
        number("q2", &C::q2, -1.001, 1.001, "", "rotation field to camera, z"),
        number("q3", &C::q3, -1.001, 1.001, "", "rotation field to camera, w"),
        number("tx", &C::tx, -1e6, 1e6, "mm", "translation in the camera's frame"),
        number("ty", &C::ty, -1e6, 1e6, "mm", "translation in the camera's frame"),
        number("tz", &C::tz, -1e6, 1e6, "mm", "translation in the camera's frame"),
        number("pixel_image_width", &C::pixel_image_width, 2, 16384, "px",
               "width of the image it was made for"),
        number("pixel_image_height", &C::pixel_image_height, 2, 16384, "px",
               "height of the image it was made for"),
    };
  }
};

/// Maps field millimetres to pixels and back (pixel centres are integers, origin top left). The two
/// directions are exact inverses for every accepted distortion, of either sign.
class CameraModel {
 public:
  /// Normalises the quaternion. Throws SettingsError, its message starting with `path`, if the quaternion's
  /// norm differs from 1 by 1e-3 or more, or if the distortion is not one-to-one inside the image.
  explicit CameraModel(const CameraCalibration& calibration, const std::string& path = "calibration");

  /// Projects a field point (mm) to a pixel. Nothing if the point lies behind the camera or beyond the
  /// distortion's one-to-one range.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_mm) const;

  /// Intersection (mm) of a pixel's ray with the plane z = height_mm. Nothing if ray and plane do not meet,
  /// or if the pixel lies beyond the distortion's one-to-one range.
  std::optional<Eigen::Vector2d> unproject(const Eigen::Vector2d& pixel, double height_mm) const;

  /// Direction of the ray through a pixel in field coordinates, not normalised. Nothing if the pixel lies
  /// beyond the distortion's one-to-one range.
  std::optional<Eigen::Vector3d> ray(const Eigen::Vector2d& pixel) const;

  /// Area (mm2) of the plane z = height_mm that one pixel covers; 0 if the pixel does not see the plane.
  double mm2_per_px(const Eigen::Vector2d& pixel, double height_mm) const;

  /// The projection centre in field millimetres: derived_camera_world_t*.
  const Eigen::Vector3d& position_mm() const { return position_mm_; }
  /// The calibration from which this model was made.
  const CameraCalibration& calibration() const { return calibration_; }

  /// All members, for copying the model to another process (pipeline/part_codec.h). for_stored() makes an
  /// instance to decode into.
  template <class Self>
  static auto stored(Self& self) {
    return std::tie(self.calibration_, self.rotation_, self.translation_mm_, self.position_mm_,
                    self.max_distorted_radius_);
  }
  /// See stored().
  static CameraModel for_stored() { return CameraModel(CameraCalibration{}); }

 private:
  CameraCalibration calibration_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_mm_, position_mm_;
  double max_distorted_radius_;  // the distortion is one-to-one below this radius
};

}  // namespace sslv
