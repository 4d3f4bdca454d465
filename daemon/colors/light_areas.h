// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

namespace sslv {

/// How bright each area of a camera's image is beside the whole, learnt from robots that stand in it. All are
/// logarithms of brightness.
class LightAreas {
 public:
  static constexpr int kColumns = 8, kRows = 6;
  static constexpr std::size_t kCount = std::size_t{kColumns} * kRows;

  /// A robot shows that this area is as bright as `here_log`.
  void learn(std::size_t area, double here_log);

  /// An area's own, and until it is known its neighbours' mean. Far from all robots that is 0: the whole's.
  double log_of(std::size_t area) const;
  /// The same, since the area was first seen.
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
