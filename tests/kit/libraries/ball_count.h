// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

/// A frame part that these libraries add.
struct BallCount {
  static constexpr std::string_view kPartName = "ball_count";
  int balls = 0;
  std::vector<double> places_mm;
  void clear() {
    balls = 0;
    places_mm.clear();
  }
};
