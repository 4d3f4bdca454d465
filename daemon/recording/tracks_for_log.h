// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/slot_queue.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sslv {

/// Our own tracks for a match log while they are not sent to the network, where the log would hear them. One
/// thread writes and never waits, another one reads.
class TracksForLog {
 public:
  /// In a log, tracks that are not sent are at least this far apart.
  static constexpr std::int64_t kPeriod_ns = 1'000'000'000 / 30;
  /// Times that differ by more are from before and after the clock was set.
  static constexpr std::int64_t kClockWasSet_ns = 1'000'000'000;
  struct Packet {
    std::int64_t time_ns = 0;  // Unix time
    std::vector<std::byte> bytes;
  };

  TracksForLog() {
    queue_.prepare([](Packet& packet) { packet.bytes.reserve(kUsualBytes); });
  }

  /// Whether a log is being written.
  void want(bool wanted) { is_wanted_.store(wanted, std::memory_order_relaxed); }

  /// Whether a log needs a packet now. For the writer, before write().
  bool is_due(std::int64_t now_ns) const noexcept {
    return is_wanted_.load(std::memory_order_relaxed) &&
           (now_ns >= written_ns_ + kPeriod_ns || now_ns < written_ns_);
  }
  /// Drops and counts the packet if the log's disk hangs.
  void write(std::int64_t now_ns, std::span<const std::byte> bytes) noexcept {
    written_ns_ = now_ns;
    Packet* const slot = queue_.to_write();
    if (slot == nullptr) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    slot->time_ns = now_ns;
    slot->bytes.assign(bytes.begin(), bytes.end());
    queue_.write();
  }

  /// Calls `use` for each packet up to `until_ns`; packets from before the clock was set back are among them.
  template <class Use>
  void read(std::int64_t until_ns, const Use& use) {
    while (const Packet* packet = queue_.to_read()) {
      if (packet->time_ns > until_ns && packet->time_ns < until_ns + kClockWasSet_ns) return;
      use(*packet);
      queue_.read();
    }
  }

  /// Number of packets dropped since the last call. For the reader.
  std::uint64_t take_dropped() noexcept { return dropped_.exchange(0, std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kSlots = 64, kUsualBytes = 8192;
  std::atomic<bool> is_wanted_ = false;
  std::int64_t written_ns_ = 0;  // used by the writer
  std::atomic<std::uint64_t> dropped_ = 0;
  SlotQueue<Packet, kSlots> queue_;
};

}  // namespace sslv
