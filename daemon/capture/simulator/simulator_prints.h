// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_hall.h"
#include "capture/simulator/simulator_paint.h"
#include "capture/simulator/simulator_scene.h"

#include <array>
#include <cstddef>

namespace sslv {

/// Nominal colours of things, indexed by label:: and paint::. Hues are at least 25 degrees apart in YUV.
inline constexpr std::array<Paint, paint::kCount> kPrints{{
    {24, 24, 27},     // clear
    {30, 92, 62},     // field
    {238, 108, 32},   // orange
    {224, 198, 38},   // yellow
    {28, 92, 196},    // blue
    {230, 64, 150},   // pink
    {60, 190, 205},   // cyan
    {108, 212, 62},   // green
    {205, 205, 200},  // white
    {24, 24, 27},     // black
    {200, 30, 35},    // red
    {120, 50, 160},   // purple
    {130, 90, 60},    // brown
    {224, 172, 140},  // skin
}};

/// The colours of a hall's robot prints and balls, which vary with their makers.
class SimulatedPrints {
 public:
  using Colors = std::array<Paint, label::kCount>;
  static constexpr std::size_t kIds = 16;

  /// `hall` must be resolved.
  explicit SimulatedPrints(const HallOptions& hall);

  const Colors& of(Team team, int id) const {
    return colors_[static_cast<std::size_t>(team)][static_cast<std::size_t>(id)];
  }
  const Paint& ball() const { return ball_; }

 private:
  std::array<std::array<Colors, kIds>, 2> colors_;
  Paint ball_;
};

/// The height in mm of a robot's print; `height_mm` is the height of the robot's team. `hall` must be
/// resolved.
double print_height_mm(const HallOptions& hall, Team team, int id, double height_mm);

}  // namespace sslv
