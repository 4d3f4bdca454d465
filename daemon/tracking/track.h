// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_motion.h"
#include "tracking/field_clock.h"
#include "tracking/sightings.h"
#include "tracking/tracker.h"
#include "tracking/tracks.h"

#include <tuple>

namespace sslv {

/// Follows robots and balls, and says where they are now: see Tracker.
class Track {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const FieldClock& clock, const BallModel& ball, const Observations& seen,
               TrackedField& out) noexcept {
    tracker_.set_ball_model(ball);
    tracker_.add(seen);
    ++out.number;
    tracker_.at(clock.now_s(), out);
  }

 private:
  Tracker tracker_;
};

}  // namespace sslv
