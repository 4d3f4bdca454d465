// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "capture/pixel_format_choice.h"
#include "capture/simulator/simulator_errors.h"
#include "capture/simulator/simulator_hall.h"
#include "geometry/field.h"

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

namespace sslv {

/// The way in which positions change from image to image.
enum class SimulatorPlacement : std::uint8_t {
  kPaths,    // endless smooth motion
  kScatter,  // new random places in each image
};
inline constexpr std::array<Choice<SimulatorPlacement>, 2> kSimulatorPlacementChoices{
    {{"paths", SimulatorPlacement::kPaths}, {"scatter", SimulatorPlacement::kScatter}}};

/// The simulator's options in a camera's "source".
struct SimulatorOptions {
  /// Limits for the pixels of one image, and for the total pixels of one image from each simulated camera.
  /// They bound the memory: each camera keeps about a dozen images.
  static constexpr std::int64_t kMaxPixels = 25'000'000, kMaxPixelsOfAll = 100'000'000;
  static constexpr std::size_t kMaxSwingPoints = 1000;
  int width = 780, height = 580;
  PixelFormat pixel_format = PixelFormat::kUyvy;
  int bits = 8;
  double frame_rate_hz = 60;
  int robots_yellow = 6, robots_blue = 6;
  int first_yellow_id = 0, first_blue_id = 0;
  int balls = 1;
  SimulatorPlacement placement = SimulatorPlacement::kPaths;
  int touching = 0;
  double touching_gap_mm = 1;
  int hidden_balls = 0;
  double hidden_share = 0.5;
  double ball_gloss = 0;
  int covered_dots = 0;
  int twins = 0;
  int distractors = 0;
  double speed = 1;
  int seed = 1;
  double noise_sigma = 2;
  double light = 1;
  double gradient = 0;
  double vignette = 0.1;
  double blur_sigma_px = 0.5;
  double exposure_ms = 0;
  double rolling_shutter_ms = 0;
  double red_gain = 1, blue_gain = 1;
  std::vector<std::array<double, 2>> light_swing, cast_swing;
  LinesMeasured lines_measured_to = LinesMeasured::kToMiddle;
  HallOptions hall;
  SimulatorErrors errors;

  static constexpr auto fields() {
    using O = SimulatorOptions;
    return std::tuple{
        number("width", &O::width, 2, 16384, "px", "width of the image"),
        number("height", &O::height, 2, 16384, "px", "height of the image"),
        choice("pixel_format", &O::pixel_format, kPixelFormatChoices, "pixel format of the camera"),
        number("bits", &O::bits, 8, 16, "",
               "bits per sample; more than 8 only with Bayer and mono formats, and used only by the fits"),
        number("frame_rate_hz", &O::frame_rate_hz, 0.0, 10000.0, "Hz",
               "images per second; 0: as fast as possible"),
        number("robots_yellow", &O::robots_yellow, 0, 16, "", "yellow robots on the field"),
        number("robots_blue", &O::robots_blue, 0, 16, "", "blue robots on the field"),
        number("first_yellow_id", &O::first_yellow_id, 0, 15, "",
               "lowest id of the yellow robots; the others follow"),
        number("first_blue_id", &O::first_blue_id, 0, 15, "",
               "lowest id of the blue robots; the others follow"),
        number("balls", &O::balls, 0, 10, "", "balls on the field"),
        choice("placement", &O::placement, kSimulatorPlacementChoices,
               "paths: continuous motion; scatter: new random positions in each image"),
        number("touching", &O::touching, 0, 22, "",
               "number of robots that stand in pairs; even, scatter only"),
        number("touching_gap_mm", &O::touching_gap_mm, 0.0, 50.0, "mm", "gap between the robots of a pair"),
        number("hidden_balls", &O::hidden_balls, 0, 10, "",
               "number of balls that a robot partly hides from this camera; scatter only"),
        number("hidden_share", &O::hidden_share, 0.0, 0.9, "", "share of such a ball that is hidden"),
        number("ball_gloss", &O::ball_gloss, 0.0, 1.0, "",
               "gloss of the balls under a lamp at one side: 0: matt, lit evenly from above; 1: with an "
               "overexposed spot, a dark side and a shadow"),
        number("covered_dots", &O::covered_dots, 0, 32, "", "robots with one side dot painted over"),
        number("twins", &O::twins, 0, 15, "", "robots of each team that wear the pattern of its first robot"),
        number("distractors", &O::distractors, 0, 60, "",
               "coloured objects on the carpet that are neither robots nor balls"),
        number("speed", &O::speed, 0.0, 10.0, "", "factor on all motion; 0: nothing moves"),
        number("seed", &O::seed, 0, 1'000'000, "",
               "each seed gives other paths; all cameras of a field need the same"),
        number(
            "noise_sigma", &O::noise_sigma, 0.0, 30.0, "",
            "noise of each red, green and blue value before a YUV camera mixes them, in 8-bit grey levels"),
        number("light", &O::light, 0.05, 3.0, "", "brightness; 1: well exposed"),
        number("gradient", &O::gradient, 0.0, 1.0, "", "fraction by which the right side is darker"),
        number("vignette", &O::vignette, 0.0, 1.0, "", "fraction by which the corners are darker"),
        number("blur_sigma_px", &O::blur_sigma_px, 0.0, 5.0, "px", "blur of the lens"),
        number("exposure_ms", &O::exposure_ms, 0.0, 100.0, "ms",
               "exposure time, which blurs moving objects; 0: no motion blur"),
        number("rolling_shutter_ms", &O::rolling_shutter_ms, 0.0, 100.0, "ms",
               "read-out time from the first to the last row: each row shows its own moment, the middle row "
               "the image's time"),
        number("red_gain", &O::red_gain, 0.2, 4.0, "", "colour cast of the light: factor on red"),
        number("blue_gain", &O::blue_gain, 0.2, 4.0, "", "colour cast of the light: factor on blue"),
        point_list("light_swing", &O::light_swing, 0, kMaxSwingPoints, 0.0, 3600.0, "",
                   "changing brightness: points [seconds, factor], ordered by time and interpolated "
                   "linearly; repeats after the last point. Empty: constant"),
        point_list("cast_swing", &O::cast_swing, 0, kMaxSwingPoints, 0.0, 3600.0, "",
                   "the same for the light's colour: [seconds, factor on red], by which blue is divided"),
        choice("lines_measured_to", &O::lines_measured_to, kLinesMeasuredChoices,
               "reference of the field's sizes: middle: the middle of each line, as the rules say; "
               "outer_edge: the outer edge of each line"),
        group("hall", &O::hall, "carpet, lamps, prints and surroundings, as in real halls"),
        group("errors", &O::errors, "errors of the camera and its calibration"),
    };
  }
};

}  // namespace sslv
