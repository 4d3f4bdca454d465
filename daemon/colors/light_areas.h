// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace sslv {

/// Brightness of each area of a camera's image relative to the whole, learnt from robots in the area. All
/// values are logarithms.
class LightAreas {
 public:
  static constexpr int kColumns = 8, kRows = 6;
  static constexpr std::size_t kCount = std::size_t{kColumns} * kRows;

  /// Adds an area's brightness, as measured on a robot.
  void learn(std::size_t area, double here_log);

  /// Brightness of an area. An area with few measurements is blended with the mean around it. Areas far from
  /// all robots have 0, the brightness of the whole image.
  double log_of(std::size_t area) const;
  /// Change of log_of() since the area was first seen.
  double change_log_of(std::size_t area) const;

 private:
  struct Area {
    int count = 0;
    double now = 0, first = 0;
  };

  template <class Value>
  double known_or_near(std::size_t area, const Value& value) const;

  std::array<Area, kCount> areas_{};  // row by row
};

}  // namespace sslv
