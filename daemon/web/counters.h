// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

namespace sslv {

/// The server's activity, readable from any thread.
struct WebCounters {
  std::atomic<int> connections = 0;  // open now, viewers included
  std::atomic<int> viewers = 0;      // WebSockets open now, without clients' second ones
  std::atomic<std::uint64_t> jpegs_encoded = 0;
  std::atomic<std::uint64_t> unsent = 0;  // answers and messages dropped for slow clients
};

/// Adds `by` to a counter for its own lifetime. The counter must outlive it. `seat`: kept alive for the same
/// time.
class ScopedCount {
 public:
  explicit ScopedCount(std::atomic<int>& counter, std::shared_ptr<const void> seat = {}, int by = 1)
      : counter_(&counter, CountDown{by}), seat_(std::move(seat)) {
    counter += by;
  }

 private:
  struct CountDown {
    int by;
    void operator()(std::atomic<int>* counter) const { *counter -= by; }
  };
  std::unique_ptr<std::atomic<int>, CountDown> counter_{nullptr, CountDown{0}};
  std::shared_ptr<const void> seat_;
};

}  // namespace sslv
