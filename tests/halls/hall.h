// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "camera_bytes.h"
#include "floor.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"
#include "lamps.h"
#include "solids.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace sslv::halls {

enum class Kind : std::uint8_t {
  kAcceptance,  // a stained carpet in uneven light, a grey floor, nothing else
  kUsual,       // a typical hall
  kHard,        // everything stronger, with people and objects at the rim
};

enum class Size : std::uint8_t { kA, kB, kC };

/// Properties of a hall. The seed chooses unset ones to suit the kind.
struct HallOptions {
  Kind kind = Kind::kUsual;
  Size size = Size::kA;
  std::uint64_t seed = 1;
  std::optional<double> px_per_mm;  // in the image centre, on the floor
  double tilt_deg = 0;              // in addition to the camera's own tilt
  std::optional<Transfer> transfer;
  std::optional<double> noise_grey, blur_px, uneven, vignette, banding;
  std::optional<int> jpeg_quality;
  std::optional<bool> is_mosaic;
  double exposure_s = 0, readout_s = 0;
  std::optional<double> height_spread_mm;
  int distractors = 0;  // flat objects of other shapes and colours on the field
};

/// A team's prints: one maker's colours, which fade and wear differently on each robot.
struct Prints {
  Color center, pink, green, top, side;
};

/// Everything that is constant over the frames of one seed.
struct Hall {
  HallOptions options;
  std::uint64_t seed = 0;  // combines the options' seed, kind and size
  FieldSize field;
  CameraCalibration calibration;
  Floor floor;
  Lighting lighting;
  Sensor sensor;
  std::vector<std::unique_ptr<Solid>> furniture;
  std::array<Prints, 2> prints;  // yellow, blue
  double fade = 0, wear = 0, height_spread_mm = 0, brightness_spread = 0.05;
  Ball::Look ball;
  double shadows = 0;  // fraction of the light that a robot blocks right beside it

  Robot::Look robot_look(std::size_t team, int id) const;
};

Hall make_hall(const HallOptions& options);

/// The robot height in the tools' settings; the true heights may differ.
constexpr double kNominalHeightMm = 140;

}  // namespace sslv::halls
