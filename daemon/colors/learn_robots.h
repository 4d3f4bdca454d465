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

/// One dot of a robot, of any colour.
struct SeenDot {
  Color3 contrast, color;  // contrast to the black around the dot; colour of the dot
  double pixel_x = 0, pixel_y = 0;
  double snr = 0;  // contrast over one sample's noise
};

/// A complete pattern found in an image, of any colours.
struct SeenRobot {
  std::size_t frame = 0;
  PatternPose pose{};
  double height_mm = 0;
  double pixel_x = 0, pixel_y = 0, px_per_mm = 0;
  double rms_mm = 0, min_r2 = 0, mean_r2 = 0;
  Color3 black;               // colour of the robot's black top
  std::vector<SeenDot> dots;  // the centre, then the side dots in the table's order
};

/// Input common to the searches for robots.
struct RobotSearch {
  std::span<const ImageView> frames;
  std::span<SmallPictures> pictures;  // one for each frame
  std::span<const double> noise_grey;
  const PatternTable& patterns;
  const Mask* mask;
  std::stop_token stop;
};

/// Finds robots by the geometry of their patterns alone: every dot must be present, in its place, and
/// brighter than one common black. `heights_mm`: possible heights of robots' tops, searched one after the
/// other.
std::vector<SeenRobot> find_patterns(const RobotSearch& search, const CameraModel& camera,
                                     std::span<const double> heights_mm);

/// Like find_patterns(), but without a calibration. Searches around the given scale, because lenses change
/// the scale across the image. Poses refer to flat_camera().
std::vector<SeenRobot> find_patterns_flat(const RobotSearch& search, double mm_per_px);

/// A camera that looks straight down from far above, so that only its scale matters.
CameraModel flat_camera(int width_px, int height_px, double mm_per_px);

/// The scale in mm per pixel at which the most patterns are complete; 0 if no pattern is complete at any
/// scale.
double find_scale(const RobotSearch& search);

}  // namespace sslv
