// SPDX-License-Identifier: Apache-2.0
#include "colors/light_areas.h"

#include <algorithm>

namespace sslv {
namespace {

/// The first kAreaLooks measurements of an area are averaged; later measurements move the average by the
/// share kFollowArea.
constexpr int kAreaLooks = 8;
constexpr double kFollowArea = 0.1, kMaxAreaLog = 0.7;

}  // namespace

void LightAreas::learn(std::size_t area, double here_log) {
  Area& one = areas_[area];
  const bool is_new = one.count < kAreaLooks;
  one.count += is_new ? 1 : 0;
  one.now += (is_new ? 1.0 / one.count : kFollowArea) * (here_log - one.now);
  one.now = std::clamp(one.now, -kMaxAreaLog, kMaxAreaLog);
  if (is_new) one.first = one.now;
}

template <class Value>
double LightAreas::known_or_near(std::size_t area, const Value& value) const {
  const double share = static_cast<double>(areas_[area].count) / kAreaLooks;
  if (share >= 1) return value(areas_[area]);
  const int row = static_cast<int>(area) / kColumns, column = static_cast<int>(area) % kColumns;
  double sum = 0, weights = 1;
  for (int y = std::max(0, row - 1); y <= std::min(kRows - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(kColumns - 1, column + 1); ++x) {
      const Area& other = areas_[static_cast<std::size_t>(y * kColumns + x)];
      sum += other.count * value(other);
      weights += other.count;
    }
  }
  return share * value(areas_[area]) + (1 - share) * sum / weights;
}

double LightAreas::log_of(std::size_t area) const {
  return known_or_near(area, [](const Area& one) { return one.now; });
}

double LightAreas::change_log_of(std::size_t area) const {
  return known_or_near(area, [](const Area& one) { return one.now - one.first; });
}

}  // namespace sslv
