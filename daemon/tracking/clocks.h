// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/frame_clock.h"
#include "tracking/sightings.h"

#include <map>
#include <tuple>

namespace sslv {

/// Estimates the true capture time of an image: see FrameClock.
class Clocks {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const CameraSightings& seen, ImageTime& out) noexcept {
    out = {};
    if (!seen.is_taken) return;
    FrameClock& clock = clocks_[seen.camera];
    out.t_s = clock.time_of(seen.t_capture_s);
    out.sigma_s = clock.sigma_s();
  }

 private:
  std::map<int, FrameClock> clocks_;  // by camera
};

}  // namespace sslv
