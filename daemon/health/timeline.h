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

/// History of the cameras over the last ten minutes, second by second. May be used from any thread.
class Timeline {
 public:
  static constexpr std::size_t kSeconds = 600;

  /// State of a camera at the end of a second.
  struct Reading {
    bool is_running = false;
    double fps = 0;
    struct Times {  // times of the frames of this second
      double latency_p50_ms, latency_p99_ms, age_p99_ms;
    };
    std::optional<Times> times;  // none: there was no frame
    unsigned robots = 0, balls = 0;
    std::uint64_t frames = 0, dropped = 0, incomplete = 0, capped = 0;  // counts since the camera's start
  };

  /// Totals over a few seconds.
  struct Sum {
    unsigned seconds = 0;  // number of seconds in which the camera ran
    std::uint64_t frames = 0, dropped = 0, incomplete = 0, capped = 0;
    std::uint64_t all() const { return frames + dropped + incomplete; }
  };

  /// Adds a second. `cameras`: by id; a missing camera is forgotten. A camera ran in a second if it was
  /// running at both ends. Times are measured with the steady clock and shifted to Unix time; the shift
  /// changes only when the computer's clock is set.
  void add(double unix_time_s, double steady_s, const std::map<int, Reading>& cameras);

  /// Forgets a camera, because another camera has its id now.
  void forget(int camera_id);

  /// Totals over the last `seconds` seconds.
  Sum sum(int camera_id, std::size_t seconds) const;

  /// The last `seconds` seconds, as the schema Timeline in docs/openapi.json.
  Json to_json(std::size_t seconds = kSeconds) const;

 private:
  struct Camera {
    Reading last;
    std::deque<std::optional<Reading>> seconds;  // counts within the second; none: the camera did not run
  };
  mutable std::mutex mutex_;
  std::deque<double> times_s_;     // on the steady clock
  double ahead_s_ = 0;             // offset from steady to Unix time
  std::map<int, Camera> cameras_;  // `seconds` of each camera has the length of times_s_
};

}  // namespace sslv
