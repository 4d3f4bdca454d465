// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>

namespace sslv {

/// Packets sent in each second of the last ten minutes. Thread-safe.
class PacketTimeline {
 public:
  static constexpr std::size_t kSeconds = 600;

  /// Call it at the end of each second. `packets_sent`: since the service's start.
  void add(double unix_time_s, std::uint64_t packets_sent);
  /// The last `seconds` seconds, as PacketTimeline of docs/openapi.json.
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
