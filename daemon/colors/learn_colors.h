// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/surfaces.h"
#include "geometry/scene.h"
#include "image/color.h"
#include "image/image.h"
#include "vision/label.h"
#include "vision/lut.h"
#include "vision/lut_from_samples.h"
#include "vision/mask.h"
#include "vision/patterns.h"

#include <array>
#include <cstddef>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

/// Input of learn_colors(). Objects that it refers to must outlive the call.
struct LearnTask {
  std::vector<ImageView> frames;  // frames of one camera, all of one size and format
  /// Provides the field, the ball's radius, the height of the teams' patterns, and the calibration. Without a
  /// calibration a flat view from above is assumed, and its scale is estimated.
  const Scene& scene;
  const PatternTable& patterns;
  const Mask* mask = nullptr;           // hidden pixels are ignored; null: no mask
  std::vector<ColorSample> guide = {};  // samples that the user pointed at; may be empty
  std::stop_token stop = {};
};

/// A robot from which colours were learnt.
struct LearntRobot {
  std::size_t frame;
  Team team;
  int id;                   // -1: the pattern table has no such code
  double pixel_x, pixel_y;  // position of its centre dot
  double orientation_rad;   // on the field; without a camera: counter-clockwise from the image's +x
  double px_per_mm;
  struct Dot {
    Label label;
    double pixel_x, pixel_y;
    Rgb color;
  };
  std::vector<Dot> dots;  // the centre, then the side dots in the table's order
};

/// A ball from which the ball's colour was learnt.
struct LearntBall {
  std::size_t frame;
  double pixel_x, pixel_y, radius_px;
  Rgb color;
};

/// Summary of one label's samples.
struct LearntLabel {
  Label label;
  std::size_t seen = 0;    // number of dots, balls, places on the carpet...
  std::size_t guided = 0;  // samples that the user pointed at
  Rgb mean{};
  double spread = 0;  // RMS distance from `mean`, in grey levels
};

struct LearntColors {
  /// One line for the user: what is missing and what to do about it. Empty: the colours were learnt.
  std::string problem;
  std::vector<std::string> notes;    // further information for the user, one line each
  std::vector<ColorSample> samples;  // input of table_from_samples()
  double noise_grey = 0;             // noise of one pixel
  double table_noise_grey = 0;       // passed to table_from_samples(); larger if colours differ more
  std::shared_ptr<const Lut> lut;    // table for detectors; null if there is a problem
  std::vector<LabelMargin> margins;  // margins of `lut` to carpet and floor in the frames
  std::vector<LearntRobot> robots;   // robots in all frames
  std::vector<LearntBall> balls;
  std::vector<LearntLabel> labels;  // labels with samples, sorted by value
  double mm_per_px = 0;             // scale at the robots' tops in the middle of the image; 0: unknown

  std::size_t robots_of(Team team) const;
};

/// Learns a camera's colours from images of the game, without a person pointing at colours. Finds robots by
/// their complete pattern of dots on black, in any colours, and balls by their shape and their position on
/// the carpet. Groups the dots by colour, and names the groups by comparing the differences between groups
/// with the differences between prints. Predicts colours missing in the images from the other colours, and
/// adds a note. Never guesses: if robots are missing, or if the light does not allow colours to be
/// distinguished, returns a problem and no table. Throws nothing. Takes 1 to 2 s for three images of 5
/// megapixels.
LearntColors learn_colors(const LearnTask& task);

}  // namespace sslv
