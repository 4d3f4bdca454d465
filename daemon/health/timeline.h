// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>

namespace sslv {

/// The cameras' last ten minutes, second by second. May be used from any thread.
class Timeline {
 public:
  static constexpr std::size_t kSeconds = 600;

  /// A camera at the end of a second.
  struct Reading {
    bool is_running = false;
    double fps = 0;
    struct Times {  // of the frames of this second
      double latency_p50_ms, latency_p99_ms, age_p99_ms;
    };
    std::optional<Times> times;  // none: there was no frame
    unsigned robots = 0, balls = 0;
    std::uint64_t frames = 0, dropped = 0, incomplete = 0, capped = 0;  // since the camera's start
  };

  /// What came in some seconds.
  struct Sum {
    unsigned seconds = 0;  // in which the camera ran
    std::uint64_t frames = 0, dropped = 0, incomplete = 0, capped = 0;
    std::uint64_t all() const { return frames + dropped + incomplete; }
  };

  /// Cameras by id; one that is not there any more is forgotten. A second counts as one in which a camera ran
  /// when it ran at both of its ends. Times come from the steady clock, shifted to Unix time; the shift
  /// changes only when the computer's clock is set.
  void add(double unix_time_s, double steady_s, const std::map<int, Reading>& cameras);

  /// Another camera has this id from now on.
  void forget(int camera_id);

  /// Of the last seconds.
  Sum sum(int camera_id, std::size_t seconds) const;

  /// The last seconds, as docs/openapi.json's Timeline.
  Json to_json(std::size_t seconds = kSeconds) const;

 private:
  struct Camera {
    Reading last;
    std::deque<std::optional<Reading>> seconds;  // counts are of the second; none: it did not run
  };
  mutable std::mutex mutex_;
  std::deque<double> times_s_;     // on the steady clock
  double ahead_s_ = 0;             // of it is the other
  std::map<int, Camera> cameras_;  // each with as many seconds as there are times
};

}  // namespace sslv
