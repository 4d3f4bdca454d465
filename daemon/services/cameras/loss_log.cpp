// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/loss_log.h"

#include <algorithm>

#include <fmt/format.h>

namespace sslv {

void LossLog::Counted::add(const Timeline::Sum& second) {
  all += second.all();
  dropped += second.dropped;
  incomplete += second.incomplete;
}

std::optional<LossLog::Line> LossLog::look(const Timeline::Sum& second, double steady_s) {
  const bool loses = second.dropped + second.incomplete > 0;
  if (!is_losing_) {
    if (!loses) return std::nullopt;
    is_losing_ = true;
    began_s_ = counted_from_s_ = steady_s - 1;
    counted_ = {};
    lost_ = 0;
    may_say_s_ = std::max(may_say_s_, began_s_ + kFirst_s);
  }
  counted_.add(second);
  lost_ += second.dropped + second.incomplete;
  if (loses) newest_s_ = steady_s;
  if (steady_s < may_say_s_) return std::nullopt;
  may_say_s_ = steady_s + kPeriod_s;

  if (counted_.lost() > 0) {
    const Line line{fmt::format(
        "{} of {} images lost in the last {:.0f} s: {} were not processed in time, {} "
        "arrived damaged",
        counted_.lost(), counted_.all, steady_s - counted_from_s_, counted_.dropped, counted_.incomplete)};
    counted_ = {};
    counted_from_s_ = steady_s;
    return line;
  }
  is_losing_ = false;
  return Line{fmt::format("no image lost in the last {:.0f} s; {} were lost in the {:.0f} s before",
                          steady_s - newest_s_, lost_, newest_s_ - began_s_),
              true};
}

}  // namespace sslv
