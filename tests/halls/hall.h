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
  kUsual,       // a hall as most are
  kHard,        // the same, all of it stronger, with people and things at the rim
};

enum class Size : std::uint8_t { kA, kB, kC };

/// What a hall is to be. What is not given is chosen by the seed as suits the kind.
struct HallOptions {
  Kind kind = Kind::kUsual;
  Size size = Size::kA;
  std::uint64_t seed = 1;
  std::optional<double> px_per_mm;  // in the middle of the picture, on the floor
  double tilt_deg = 0;              // of the camera, besides its own
  std::optional<Transfer> transfer;
  std::optional<double> noise_grey, blur_px, uneven, vignette, banding;
  std::optional<int> jpeg_quality;
  std::optional<bool> is_mosaic;
  double exposure_s = 0, readout_s = 0;
  std::optional<double> height_spread_mm;
  int distractors = 0;  // flat things of other shapes and colours on the field
};

/// The prints of one team: one maker's colours, which fade and wear from robot to robot.
struct Prints {
  Color center, pink, green, top, side;
};

/// Everything that stays over the frames of one seed.
struct Hall {
  HallOptions options;
  std::uint64_t seed = 0;  // of everything in it: the options' seed, kind and size
  FieldSize field;
  CameraCalibration calibration;
  Floor floor;
  Lighting lighting;
  Sensor sensor;
  std::vector<std::unique_ptr<Solid>> furniture;
  std::array<Prints, 2> prints;  // yellow, blue
  double fade = 0, wear = 0, height_spread_mm = 0, brightness_spread = 0.05;
  Ball::Look ball;
  double shadows = 0;  // share of the light that a robot keeps from the floor right beside it

  Robot::Look robot_look(std::size_t team, int id) const;
};

Hall make_hall(const HallOptions& options);

/// The height that the tools are told; true ones may differ.
constexpr double kNominalHeightMm = 140;

}  // namespace sslv::halls
