// SPDX-License-Identifier: Apache-2.0
#pragma once

// Memory layout of an ImageRing: head, slots, blocks, and after them setups, which are not mapped. Frames and
// setups are clip blocks (clip_format.h), but without the checksum of a frame's payload, because computing it
// would delay the camera's thread.

#include "clips/clip_format.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sslv {

/// Change this text whenever the layout in this file or the layout of a frame's head changes.
inline constexpr std::string_view kRingMagic = "SSLVRING0002";
/// Replaces kRingMagic while the memory of a crashed process is read. Zeros mean that the process ended
/// normally.
inline constexpr std::string_view kRingIsRead = "SSLVRINGREAD";

inline constexpr std::size_t kRingPage = 4096;
inline constexpr std::size_t kRingSlots = 1 << 14;  // maximum number of frames
/// Maximum number of setups. Setup n is stored at place n % kRingSetups; unused places take no memory.
inline constexpr std::uint32_t kRingSetups = 128;

struct RingHead {
  std::array<char, 16> magic{};
  std::uint64_t room = 0;                       // capacity for blocks, in bytes
  std::atomic<std::uint64_t> begin{0}, end{0};  // numbers of the frames in the ring: [begin, end)
  std::atomic<std::uint64_t> dropped{0};
};
static_assert(sizeof(RingHead) <= kRingPage && std::atomic<std::uint64_t>::is_always_lock_free);

enum RingSlotState : std::uint64_t { kRingEmpty = 0, kRingKept = 1, kRingHeld = 2 };

struct RingSlot {
  std::atomic<std::uint64_t> state{0};  // frame number * 4 + RingSlotState
  std::atomic<std::int64_t> arrived_ns{0};
  std::atomic<std::uint32_t> setup{0};
  std::uint64_t begin = 0, bytes = 0;  // start of the frame's block in the block area; size
};

constexpr std::size_t ring_aligned(std::size_t bytes, std::size_t to = 64) {
  return (bytes + to - 1) / to * to;
}
inline constexpr std::size_t kRingSetupBytes =
    ring_aligned(kClipBlockBytes + kClipSetupBytes + kMaxClipJsonBytes + kMaxClipTableBytes, kRingPage);
inline constexpr std::size_t kRingBlocksAt =
    ring_aligned(kRingPage + kRingSlots * sizeof(RingSlot), kRingPage);
/// Bytes of the mapping; also the offset of the setups in the file.
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
