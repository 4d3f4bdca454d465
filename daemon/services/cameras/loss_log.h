// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "health/timeline.h"

#include <cstdint>
#include <optional>
#include <string>

namespace sslv {

/// Log lines about a camera's lost images: one line ten seconds after the first loss, one a minute while
/// losses continue, and one after they end; never more than one a minute.
class LossLog {
 public:
  static constexpr double kFirst_s = 10, kPeriod_s = 60;

  struct Line {
    std::string text;  // without the camera's name
    bool is_end = false;
  };

  /// Call it once a second with that second's counts. `steady_s`: on the steady clock.
  std::optional<Line> look(const Timeline::Sum& second, double steady_s);

 private:
  struct Counted {
    std::uint64_t all = 0, dropped = 0, incomplete = 0;
    std::uint64_t lost() const { return dropped + incomplete; }
    void add(const Timeline::Sum& second);
  };

  double may_say_s_ = 0;  // time from which the next line is allowed
  bool is_losing_ = false;
  // Only while is_losing_:
  double began_s_ = 0, counted_from_s_ = 0, newest_s_ = 0;
  Counted counted_;  // since counted_from_s_
  std::uint64_t lost_ = 0;
};

}  // namespace sslv
