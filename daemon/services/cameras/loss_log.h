// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "health/timeline.h"

#include <cstdint>
#include <optional>
#include <string>

namespace sslv {

/// What the log says of a camera's lost images: a line ten seconds after the first, one a minute while it
/// goes on, and its end; never more than one a minute.
class LossLog {
 public:
  static constexpr double kFirst_s = 10, kPeriod_s = 60;

  struct Line {
    std::string text;  // without the camera
    bool is_end = false;
  };

  /// Once a second, with what came in it. `steady_s`: on the steady clock.
  std::optional<Line> look(const Timeline::Sum& second, double steady_s);

 private:
  struct Counted {
    std::uint64_t all = 0, dropped = 0, incomplete = 0;
    std::uint64_t lost() const { return dropped + incomplete; }
    void add(const Timeline::Sum& second);
  };

  double may_say_s_ = 0;  // the next line
  bool is_losing_ = false;
  // While it is:
  double began_s_ = 0, counted_from_s_ = 0, newest_s_ = 0;
  Counted counted_;  // since counted_from_s_
  std::uint64_t lost_ = 0;
};

}  // namespace sslv
