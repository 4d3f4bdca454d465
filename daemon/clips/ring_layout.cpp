// SPDX-License-Identifier: Apache-2.0
#include "clips/ring_layout.h"

#include <cstring>

namespace sslv {

std::optional<ClipFrame> frame_in(std::span<const std::byte> images, const RingSlot& slot,
                                  std::vector<std::byte>& whole) {
  if (slot.begin > images.size() || slot.bytes > images.size() - slot.begin || slot.bytes < kClipFrameBytes ||
      slot.payload_bytes > slot.bytes)
    return std::nullopt;
  const auto own = images.subspan(slot.begin, slot.bytes);
  constexpr std::uint64_t kAfterAWholeOne = 1;  // of images in tiles
  const auto head = frame_head_of(own.first<kClipFrameBytes>(), slot.payload_bytes, kAfterAWholeOne);
  if (!head) return std::nullopt;
  std::size_t at = kClipFrameBytes;
  const auto next = [&](std::uint64_t count) {
    const auto out = own.subspan(at, static_cast<std::size_t>(count));
    at += out.size();
    return out;
  };
  ClipFrame out;
  out.info = head->info;
  out.info.camera_id = slot.camera_id;
  out.info.times.arrived_ns = slot.arrived_ns.load(std::memory_order_relaxed);
  out.setup = head->setup;
  out.packet = next(head->packet_bytes);
  out.memory = next(head->memory_bytes);
  out.tiles = next(head->tiles_bytes);
  out.tile_px = head->tile_px;
  at = ring_aligned(at);
  if (at > own.size() || head->image_bytes > own.size() - at) return std::nullopt;
  const auto pixels = own.subspan(at, static_cast<std::size_t>(head->image_bytes));
  const std::size_t row_bytes = clip_plane_bytes(head->format, head->width, 1);
  const std::size_t plane_bytes = clip_plane_bytes(head->format, head->width, head->height);
  out.image = {.data = reinterpret_cast<const std::uint8_t*>(pixels.data()),
               .width = head->width,
               .height = head->height,
               .stride_bytes = static_cast<std::ptrdiff_t>(row_bytes),
               .format = head->format,
               .to_low_bits = head->is_deep ? static_cast<std::ptrdiff_t>(plane_bytes) : 0};
  if (out.tile_px == 0) return out;
  if (ring_image_bytes(out) != pixels.size()) return std::nullopt;
  whole.resize(plane_bytes * (head->is_deep ? 2 : 1));
  out.image.data = reinterpret_cast<const std::uint8_t*>(whole.data());
  const std::byte* from = pixels.data();
  each_stretch(out, [&](const std::uint8_t* stretch, std::size_t count) {
    std::memcpy(whole.data() + (stretch - out.image.data), from, count);
    from += count;
  });
  return out;
}

}  // namespace sslv
