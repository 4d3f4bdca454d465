// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/small_picture.h"
#include "geometry/scene.h"
#include "image/image.h"
#include "vision/mask.h"
#include "vision/pattern_fit.h"
#include "vision/patterns.h"

#include <cstddef>
#include <span>
#include <stop_token>
#include <vector>

namespace sslv {

/// One dot of a robot, whatever its colour.
struct SeenDot {
  Color3 contrast, color;  // to the black around it; of the dot
  double pixel_x = 0, pixel_y = 0;
  double snr = 0;  // contrast over one sample's noise
};

/// A whole pattern that the image shows, whatever its colours.
struct SeenRobot {
  std::size_t frame = 0;
  PatternPose pose{};
  double height_mm = 0;
  double pixel_x = 0, pixel_y = 0, px_per_mm = 0;
  double rms_mm = 0, min_r2 = 0, mean_r2 = 0;
  Color3 black;               // of its top
  std::vector<SeenDot> dots;  // the centre, then the side dots as the table has them
};

/// What stays the same while robots are looked for.
struct RobotSearch {
  std::span<const ImageView> frames;
  std::span<SmallPictures> pictures;  // of each frame
  std::span<const double> noise_grey;
  const PatternTable& patterns;
  const Mask* mask;
  std::stop_token stop;
};

/// Finds robots by their patterns' geometry alone: every dot is there, in its place, brighter than one common
/// black. `heights_mm` are heights of robots' tops, which are checked one after the other.
std::vector<SeenRobot> find_patterns(const RobotSearch& search, const CameraModel& camera,
                                     std::span<const double> heights_mm);

/// The same without a calibration, at about that scale: lenses make it differ over the image. Poses are
/// those of flat_camera().
std::vector<SeenRobot> find_patterns_flat(const RobotSearch& search, double mm_per_px);

/// A camera that looks straight down from far above, so that a scale is all there is to know of it.
CameraModel flat_camera(int width_px, int height_px, double mm_per_px);

/// The scale at which most patterns are whole, in mm per pixel; 0 when none is at any.
double find_scale(const RobotSearch& search);

}  // namespace sslv
