// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>

namespace sslv {

/// How many packets left in each second of the last ten minutes. May be used from any thread.
class PacketTimeline {
 public:
  static constexpr std::size_t kSeconds = 600;

  /// At the end of a second. `packets_sent`: since the service's start.
  void add(double unix_time_s, std::uint64_t packets_sent);
  /// The last seconds, as docs/openapi.json's PacketTimeline.
  Json to_json(std::size_t seconds) const;

 private:
  struct Second {
    double time_s;
    double packets_per_s;
  };
  mutable std::mutex mutex_;
  std::deque<Second> seconds_;
  double last_s_ = 0;  // 0: nothing was added yet
  std::uint64_t last_sent_ = 0;
};

}  // namespace sslv
