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

/// A point of the field that somebody pointed at in the image.
struct ClickedPoint {
  Eigen::Vector2d pixel;
  std::string name;                         // one of named_points(), or empty
  std::optional<Eigen::Vector2d> place_mm;  // instead of a name
};

/// Clicks, and the places that they may mean.
struct Clicks {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<NamedPoint> places;
  bool names_known = false;  // then place i was said for pixel i

  /// What a click most likely means, seen by `camera`.
  struct Meaning {
    const NamedPoint* place = nullptr;  // none: the camera shows none of them
    double off_px = 1e9;
    bool is_far = true;  // too far off to have been meant
  };
  Meaning meaning(std::size_t pixel, const LensCamera& camera) const;
  bool has_far_one(const LensCamera& camera) const;
};

/// Further off than this, in shares of the image's width, nobody's hand is.
inline constexpr double kFarClickShare = 0.012;

/// `points` are the named points of the field. Throws SettingsError for clicks that name no point, or are too
/// few.
Clicks read_clicks(std::span<const ClickedPoint> clicked, std::span<const NamedPoint> points);

}  // namespace sslv
