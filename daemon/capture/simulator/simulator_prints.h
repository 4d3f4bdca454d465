// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_hall.h"
#include "capture/simulator/simulator_paint.h"
#include "capture/simulator/simulator_scene.h"

#include <array>
#include <cstddef>

namespace sslv {

/// What things are painted with, by label and paint::, where prints do not differ. Hues lie 25 degrees or
/// more apart in YUV.
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

/// The prints of a hall's robots and the paint of its balls: other makers, other colours.
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

/// The height of a robot's print where `height_mm` is its team's. `hall` must be resolved.
double print_height_mm(const HallOptions& hall, Team team, int id, double height_mm);

}  // namespace sslv
