// SPDX-License-Identifier: Apache-2.0
#pragma once

// How an ImageRing lies in its memory: head, slots, blocks, and behind them setups, which are no part of the
// mapping. Frames and setups are a clip's blocks (clip_format.h), of which only the checksum of a frame's
// payload is missing: that is for a thread which has the time.

#include "clips/clip_format.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sslv {

/// To be another one whenever something here, or in a frame's head, lies otherwise.
inline constexpr std::string_view kRingMagic = "SSLVRING0002";
/// Instead of it while somebody reads what a crash left. Zeros: it ended well.
inline constexpr std::string_view kRingIsRead = "SSLVRINGREAD";

inline constexpr std::size_t kRingPage = 4096;
inline constexpr std::size_t kRingSlots = 1 << 14;  // frames at most
/// As many setups, each in the place that its number has; those that are not used take no memory.
inline constexpr std::uint32_t kRingSetups = 128;

struct RingHead {
  std::array<char, 16> magic{};
  std::uint64_t room = 0;                       // bytes for blocks
  std::atomic<std::uint64_t> begin{0}, end{0};  // numbers of the frames that are there: [begin, end)
  std::atomic<std::uint64_t> dropped{0};
};
static_assert(sizeof(RingHead) <= kRingPage && std::atomic<std::uint64_t>::is_always_lock_free);

enum RingSlotState : std::uint64_t { kRingEmpty = 0, kRingKept = 1, kRingHeld = 2 };

struct RingSlot {
  std::atomic<std::uint64_t> state{0};  // number of the frame * 4 + RingSlotState
  std::atomic<std::int64_t> arrived_ns{0};
  std::atomic<std::uint32_t> setup{0};
  std::uint64_t begin = 0, bytes = 0;  // of its block, in the room for blocks
};

constexpr std::size_t ring_aligned(std::size_t bytes, std::size_t to = 64) {
  return (bytes + to - 1) / to * to;
}
inline constexpr std::size_t kRingSetupBytes =
    ring_aligned(kClipBlockBytes + kClipSetupBytes + kMaxClipJsonBytes + kMaxClipTableBytes, kRingPage);
inline constexpr std::size_t kRingBlocksAt =
    ring_aligned(kRingPage + kRingSlots * sizeof(RingSlot), kRingPage);
/// Where setups begin.
constexpr std::size_t ring_mapped_bytes(std::size_t room) {
  return ring_aligned(kRingBlocksAt + room, kRingPage);
}
constexpr std::uint64_t ring_file_bytes(std::size_t room) {
  return std::uint64_t{ring_mapped_bytes(room)} + kRingSetups * std::uint64_t{kRingSetupBytes};
}
constexpr std::uint64_t ring_setup_place(std::size_t room, std::uint32_t number) {
  return ring_mapped_bytes(room) + number % kRingSetups * std::uint64_t{kRingSetupBytes};
}

}  // namespace sslv
