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

/// What colours are to be learnt from. What it refers to must outlive the learning.
struct LearnTask {
  std::vector<ImageView> frames;  // of one camera, all of one size and format
  /// The field, the ball's radius, the height of the teams' patterns. Without a camera a flat view from above
  /// is assumed, of a scale that is found out.
  const Scene& scene;
  const PatternTable& patterns;
  const Mask* mask = nullptr;           // what it hides does not teach; none: all is looked at
  std::vector<ColorSample> guide = {};  // what an admin pointed at; may be empty
  std::stop_token stop = {};
};

/// A robot that taught its colours.
struct LearntRobot {
  std::size_t frame;
  Team team;
  int id;                   // -1: no code of the table has these colours
  double pixel_x, pixel_y;  // of its centre dot
  double orientation_rad;   // on the field; without a camera: counter-clockwise from the image's +x
  double px_per_mm;
  struct Dot {
    Label label;
    double pixel_x, pixel_y;
    Rgb color;
  };
  std::vector<Dot> dots;  // the centre, then the side dots as the table has them
};

/// A ball that taught its colour.
struct LearntBall {
  std::size_t frame;
  double pixel_x, pixel_y, radius_px;
  Rgb color;
};

/// What is known of one label.
struct LearntLabel {
  Label label;
  std::size_t seen = 0;    // things: dots, balls, places on the carpet...
  std::size_t guided = 0;  // samples that an admin pointed at
  Rgb mean{};
  double spread = 0;  // root mean square distance from that, in grey levels
};

struct LearntColors {
  /// One line for people: what is missing and what to do about it. Empty: the colours were learnt.
  std::string problem;
  std::vector<std::string> notes;    // what else people should know, a line each
  std::vector<ColorSample> samples;  // what the table was made of, by lut_from_samples
  double noise_grey = 0;             // of one pixel
  double table_noise_grey = 0;       // what lut_from_samples was told: more where colours differ by more
  std::shared_ptr<const Lut> lut;    // for detectors; none when there is a problem
  std::vector<LabelMargin> margins;  // of that table to the carpet and the floor of the frames
  std::vector<LearntRobot> robots;   // of all frames
  std::vector<LearntBall> balls;
  std::vector<LearntLabel> labels;  // that have samples, by value
  double mm_per_px = 0;             // on the robots' tops in the middle of the image; 0: not found out

  std::size_t robots_of(Team team) const;
};

/// Learns a camera's colours from images of the game, with nobody pointing at anything: a robot is known by
/// its whole pattern of dots on black, whatever their colours, a ball by its shape and by being on the
/// carpet; the colours of the dots fall into groups that differ as the prints do. Colours that are not in the
/// images are predicted from those that are, and a note says so. Never guesses: where robots are missing,
/// or light does not let colours be told apart, there is a problem and no table. Throws nothing; takes a
/// second or two for three images of 5 megapixels.
LearntColors learn_colors(const LearnTask& task);

}  // namespace sslv
