// SPDX-License-Identifier: Apache-2.0
#pragma once

// How an ImageRing lies in its memory, for itself and for LeftRing, which reads what a crashed process left
// there: head, slots, images, and behind them setups, which are no part of the mapping.

#include "clips/clip.h"
#include "clips/clip_format.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace sslv {

/// To be another one whenever something here, or in what a frame's head says, lies otherwise.
inline constexpr std::string_view kRingMagic = "SSLVRING0001";
/// Instead of it while somebody reads what a crash left. Zeros: it ended well.
inline constexpr std::string_view kRingIsRead = "SSLVRINGREAD";

inline constexpr std::size_t kRingPage = 4096;
inline constexpr std::size_t kRingSlots = 1 << 14;  // frames at most
/// As many setups, each in the place that its number has; those that are not used take no memory.
inline constexpr std::uint32_t kRingSetups = 128;
inline constexpr std::size_t kRingSetupHeadBytes = 32;
inline constexpr std::size_t kRingSetupBytes = kRingPage + kMaxClipJsonBytes + kMaxClipTableBytes;

struct RingHead {
  std::array<char, 16> magic{};
  std::uint64_t image_bytes = 0;
  std::atomic<std::uint64_t> begin{0}, end{0};  // numbers of the frames that are there: [begin, end)
  std::atomic<std::uint64_t> dropped{0};
};
static_assert(sizeof(RingHead) <= kRingPage && std::atomic<std::uint64_t>::is_always_lock_free);

enum RingSlotState : std::uint64_t { kRingEmpty = 0, kRingKept = 1, kRingHeld = 2 };

struct RingSlot {
  std::atomic<std::uint64_t> state{0};  // number of the frame * 4 + RingSlotState
  std::atomic<std::int64_t> arrived_ns{0};
  std::atomic<std::uint32_t> setup{0};
  std::uint32_t camera_id = 0;
  std::uint64_t begin = 0, bytes = 0;  // among the images
  std::uint64_t payload_bytes = 0;     // as a clip's frame
};

constexpr std::size_t ring_aligned(std::size_t bytes, std::size_t to = 64) {
  return (bytes + to - 1) / to * to;
}
inline constexpr std::size_t kRingImagesAt =
    ring_aligned(kRingPage + kRingSlots * sizeof(RingSlot), kRingPage);
/// Where setups begin.
constexpr std::size_t ring_mapped_bytes(std::size_t image_bytes) {
  return ring_aligned(kRingImagesAt + image_bytes, kRingPage);
}
constexpr std::uint64_t ring_file_bytes(std::size_t image_bytes) {
  return std::uint64_t{ring_mapped_bytes(image_bytes)} + kRingSetups * std::uint64_t{kRingSetupBytes};
}
constexpr std::uint64_t ring_setup_place(std::size_t image_bytes, std::uint32_t number) {
  return ring_mapped_bytes(image_bytes) + number % kRingSetups * std::uint64_t{kRingSetupBytes};
}

/// Calls `copy(data, bytes)` for what of a frame's image is kept, in its order: one plane after the other,
/// each row by row; all of it, or the tiles that are marked.
template <class Copy>
void each_stretch(const ClipFrame& frame, const Copy& copy) {
  const ImageView& image = frame.image;
  const std::size_t pixel = static_cast<std::size_t>(bytes_per_pixel(image.format));
  for (int plane = 0; plane < (image.to_low_bits != 0 ? 2 : 1); ++plane) {
    const std::ptrdiff_t shift = plane == 0 ? 0 : image.to_low_bits;
    if (frame.tile_px == 0) {
      const std::size_t row_bytes = static_cast<std::size_t>(image.width) * pixel;
      if (image.stride_bytes == static_cast<std::ptrdiff_t>(row_bytes)) {
        copy(image.data + shift, row_bytes * static_cast<std::size_t>(image.height));
      } else {
        for (int y = 0; y < image.height; ++y) copy(image.row(y) + shift, row_bytes);
      }
      continue;
    }
    const ClipTiles tiles{image.width, image.height, frame.tile_px};
    tiles.each_row(frame.tiles, [&](int x, int y, int pixels) {
      copy(image.row(y) + shift + static_cast<std::size_t>(x) * pixel,
           static_cast<std::size_t>(pixels) * pixel);
    });
  }
}

/// Of all of them together.
inline std::size_t ring_image_bytes(const ClipFrame& frame) {
  const ImageView& image = frame.image;
  const std::size_t planes = image.to_low_bits != 0 ? 2 : 1;
  if (frame.tile_px == 0) return planes * clip_plane_bytes(image.format, image.width, image.height);
  const std::uint64_t pixels = ClipTiles{image.width, image.height, frame.tile_px}.pixels(frame.tiles);
  return planes * static_cast<std::size_t>(pixels) * static_cast<std::size_t>(bytes_per_pixel(image.format));
}

/// The frame of a slot; `images`: all that belong to it, slot.begin is a place there. `whole`: memory for an
/// image that is put together of tiles. None where the slot or the bytes are damaged.
std::optional<ClipFrame> frame_in(std::span<const std::byte> images, const RingSlot& slot,
                                  std::vector<std::byte>& whole);

}  // namespace sslv
