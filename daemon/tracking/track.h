// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_motion.h"
#include "tracking/field_clock.h"
#include "tracking/sightings.h"
#include "tracking/tracker.h"
#include "tracking/tracks.h"

#include <tuple>

namespace sslv {

/// Tracks robots and balls and predicts them to the current time: see Tracker.
class Track {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const FieldClock& clock, const BallModel& ball, const ArrivedSightings& arrived,
               const Observations& seen, TrackedField& out) noexcept {
    const double now_s = clock.now_s();
    // Once the clock is set back, all previous measurements lie in the future.
    constexpr double kSetBack_s = 0.5;
    if (now_s < now_s_ - kSetBack_s) tracker_ = {};
    now_s_ = now_s;
    tracker_.set_ball_model(ball);
    const CameraSightings& image = arrived.image;
    if (!image.is_of_other_computer) tracker_.look(image.camera, image.t_capture_s);
    tracker_.add(seen);
    ++out.number;
    tracker_.at(clock.now_s(), out);
  }

 private:
  double now_s_ = 0;
  Tracker tracker_;
};

}  // namespace sslv
