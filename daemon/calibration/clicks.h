// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/lens_camera.h"
#include "calibration/painted_curves.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A point of the field that a user clicked in the image.
struct ClickedPoint {
  Eigen::Vector2d pixel;
  std::string name;                         // one of named_points(), or empty
  std::optional<Eigen::Vector2d> place_mm;  // position on the field, instead of a name
};

/// Clicks, and the points of the field to which they may refer.
struct Clicks {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<NamedPoint> places;
  bool names_known = false;  // true: places[i] was given for pixels[i]

  /// The point that a click most likely means, as seen by `camera`.
  struct Meaning {
    const NamedPoint* place = nullptr;  // null: the camera shows none of the places
    double off_px = 1e9;
    bool is_far = true;  // the place is too far away to be intended
  };
  Meaning meaning(std::size_t pixel, const LensCamera& camera) const;
  bool has_far_one(const LensCamera& camera) const;
  /// Largest plausible click error.
  static double far_px(const LensCamera& camera);
};

/// Largest plausible click error, as a share of the image's width.
inline constexpr double kFarClickShare = 0.012;

/// `points`: the named points of the field. Throws SettingsError if a click names none of these points, or if
/// there are one or two clicks.
Clicks read_clicks(std::span<const ClickedPoint> clicked, std::span<const NamedPoint> points);

}  // namespace sslv
