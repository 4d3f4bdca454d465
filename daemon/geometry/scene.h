// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/camera_model.h"
#include "geometry/field.h"

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace sslv {

/// Index into per-team arrays.
enum class Team : std::uint8_t { kYellow = 0, kBlue = 1 };
constexpr Team largest(Team) {
  return Team::kBlue;
}
constexpr const char* name_of(Team team) {
  return team == Team::kYellow ? "yellow" : "blue";
}

/// Data needed to locate a camera's detections: the field, the camera model and the height of the teams'
/// patterns. Immutable while a frame is processed.
struct Scene {
  FieldSize field;
  std::optional<CameraModel> camera;  // none before calibration: nothing can be located then
  std::array<double, 2> robot_height_mm{140, 140};
  /// Robot ids in play, by Team; unknown if no bit is set.
  std::array<std::bitset<256>, 2> roster{};

  /// Height of the team's patterns above the floor (mm).
  double height_of(Team team) const { return robot_height_mm[static_cast<std::size_t>(team)]; }
};

}  // namespace sslv
