// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/slot_queue.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sslv {

/// Our own tracks for a match log while they are not sent to the network, where the log would hear them. One
/// thread writes and never waits, another one reads.
class TracksForLog {
 public:
  /// In a log, tracks that are not sent are this far apart in the mean, or farther.
  static constexpr std::int64_t kPeriod_ns = 1'000'000'000 / 30;
  struct Packet {
    std::int64_t steady_ns = 0;  // as of steady_ns(), which no one sets
    std::int64_t time_ns = 0;    // Unix time
    std::vector<std::byte> bytes;
  };

  TracksForLog() {
    queue_.prepare([](Packet& packet) { packet.bytes.reserve(kUsualBytes); });
  }

  /// Whether a log is being written.
  void want(bool wanted) { is_wanted_.store(wanted, std::memory_order_relaxed); }

  /// Whether a log needs a packet now. For the writer, before write().
  bool is_due(std::int64_t steady_ns) const noexcept {
    return is_wanted_.load(std::memory_order_relaxed) && steady_ns >= due_ns_;
  }
  /// Drops and counts the packet if the log's disk hangs.
  void write(std::int64_t steady_ns, std::int64_t time_ns, std::span<const std::byte> bytes) noexcept {
    due_ns_ = std::max(due_ns_, steady_ns - kPeriod_ns) + kPeriod_ns;
    Packet* const slot = queue_.to_write();
    if (slot == nullptr) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    slot->steady_ns = steady_ns;
    slot->time_ns = time_ns;
    slot->bytes.assign(bytes.begin(), bytes.end());
    queue_.write();
  }

  /// Calls `use` for each packet up to `until_steady_ns`.
  template <class Use>
  void read(std::int64_t until_steady_ns, const Use& use) {
    for (const Packet* packet;
         (packet = queue_.to_read()) != nullptr && packet->steady_ns <= until_steady_ns;) {
      use(*packet);
      queue_.read();
    }
  }
  void discard() {
    read(std::numeric_limits<std::int64_t>::max(), [](const Packet&) {});
    take_dropped();
  }

  /// Number of packets dropped since the last call. For the reader.
  std::uint64_t take_dropped() noexcept { return dropped_.exchange(0, std::memory_order_relaxed); }

 private:
  // For a disk that hangs for half a minute.
  static constexpr std::size_t kSlots = 1024, kUsualBytes = 2048;
  std::atomic<bool> is_wanted_ = false;
  std::int64_t due_ns_ = 0;  // used by the writer
  std::atomic<std::uint64_t> dropped_ = 0;
  SlotQueue<Packet, kSlots> queue_;
};

}  // namespace sslv
