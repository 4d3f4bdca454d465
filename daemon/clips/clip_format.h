// SPDX-License-Identifier: Apache-2.0
#pragma once

// The binary format of clips, for their writer and reader. All numbers are little-endian. docs/recording.md
// describes the format for authors of tools: keep both in sync.

#include "clips/clip.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace sslv {

/// Like PNG's signature, contains a non-ASCII byte, and line ends that a text transfer would change.
inline constexpr std::string_view kClipMagic = "\x89SSL_CLIP\r\n\x1a";
inline constexpr std::uint32_t kClipVersion = 1;
inline constexpr std::size_t kClipHeadBytes = 16;     // header of the file
inline constexpr std::size_t kClipBlockBytes = 32;    // head of each block, before its payload
inline constexpr std::size_t kClipFrameBytes = 128;   // head of a frame's payload
inline constexpr std::size_t kClipSetupBytes = 16;    // head of a setup's payload
inline constexpr std::size_t kClipMissingBytes = 8;   // whole payload of a kMissing block
inline constexpr std::size_t kClipIndexBytes = 40;    // line in the index, one per block
inline constexpr std::size_t kClipTrailerBytes = 16;  // trailer at the end of the file
inline constexpr std::string_view kClipTrailerMagic = "SSL_CEND";

/// Limits for writers and readers. Files may be sparse, so a file's size does not bound the sizes stated in
/// it. With these limits, opening a file and reading its frames, or opening it and reading a setup, takes at
/// most 64 MB of memory. A replay needs more memory, because it holds a frame and its setup at once.
inline constexpr std::uint64_t kMaxClipBlocks = 1 << 19;  // eight cameras at 75 Hz for 14 minutes
inline constexpr std::size_t kMaxClipCameras = 256;
inline constexpr std::size_t kMaxClipSetups = 16384;
inline constexpr std::size_t kMaxClipEvents = 4096;
/// Number of blocks reserved for use after the last frame.
inline constexpr std::uint64_t kClipEndBlocks = kMaxClipEvents + kMaxClipCameras + 8;
/// Maximum bytes of a setup's JSON, whose parsed values take up to twenty times the memory of the text.
inline constexpr std::size_t kMaxClipJsonBytes = std::size_t{1} << 20U;
/// Maximum bytes of the JSON of an event or of ClipAbout; maximum bytes of all these JSON texts together.
inline constexpr std::size_t kMaxClipEventBytes = std::size_t{64} << 10U;
inline constexpr std::size_t kMaxClipEventBytesInAll = std::size_t{1} << 20U;
inline constexpr std::size_t kMaxClipTableBytes = std::size_t{20} << 20U;  // with 8-bit channels: 16 MiB
inline constexpr std::size_t kMaxClipPacketBytes = 65'507;                 // the largest datagram
inline constexpr std::size_t kMaxClipMemoryBytes = std::size_t{1} << 20U;
inline constexpr std::size_t kMaxClipImageBytes = std::size_t{48} << 20U;  // 25 megapixels of 2 bytes
/// Limit for a reader's memory: one image, and the entries of all frames. A clip of very many frames may
/// therefore only have images smaller than kMaxClipImageBytes; with larger images, it would take terabytes.
inline constexpr std::size_t kMaxClipBytesInMemory = 52'000'000;

enum class ClipBlock : std::uint32_t { kAbout = 1, kSetup, kFrame, kEvent, kMissing, kIndex };

struct ClipBlockHead {
  std::uint32_t type = 0;  // ClipBlock, or a type of a later version
  std::uint32_t camera_id = 0;
  std::uint64_t bytes = 0;   // size of the payload
  std::int64_t time_ns = 0;  // Unix time; 0: none
  std::uint32_t sum = 0;     // CRC-32 of the payload
};

/// Start of a frame's payload; packet, memory and image follow.
struct ClipFrameHead {
  FrameInfo info{};         // without arrived_ns and camera_id, which is in the block head
  std::uint32_t setup = 0;  // number of the setup
  PixelFormat format = PixelFormat::kMono8;
  int width = 0, height = 0;  // px; 0: no image
  bool is_deep = false;       // a plane of low bits follows the pixels
  std::uint64_t packet_bytes = 0, memory_bytes = 0, image_bytes = 0;
  /// Earlier versions could keep parts of an image. Readers skip these parts, so the frame has no image.
  bool is_in_parts = false;

  bool has_image() const { return width != 0 && !is_in_parts; }
};

/// Contents of a setup's payload.
struct ClipSetupParts {
  std::uint32_t number = 0;
  std::span<const std::byte> json, table;
};

/// A block's line in the index.
struct ClipIndexLine {
  std::uint64_t place = 0;  // offset in the file
  std::uint64_t bytes = 0;  // size of the payload
  double t_capture_s = 0;   // capture time of a frame; 0 for other blocks
  std::uint32_t type = 0, camera_id = 0;
  std::uint32_t number = 0;  // number of a frame or setup; 0 for other blocks
  bool has_memory = false, is_whole = false;
};

/// Resets optional times that are not finite, because a frame with invalid times would be rejected.
void leave_out_bad_times(CaptureTimes& times);

std::array<std::byte, kClipHeadBytes> clip_head();
std::array<std::byte, kClipBlockBytes> encoded(const ClipBlockHead& head);
std::array<std::byte, kClipFrameBytes> encoded(const ClipFrameHead& head);
std::array<std::byte, kClipIndexBytes> encoded(const ClipIndexLine& line);
std::array<std::byte, kClipTrailerBytes> clip_trailer(std::uint64_t index_place);

/// Nullopt if the bytes are damaged.
std::optional<ClipBlockHead> block_head_of(std::span<const std::byte, kClipBlockBytes> bytes);
/// Nullopt if the bytes are damaged or do not fit a payload of `payload_bytes`. All sizes in the result are
/// consistent, but the image may be larger than kMaxClipImageBytes.
std::optional<ClipFrameHead> frame_head_of(std::span<const std::byte, kClipFrameBytes> bytes,
                                           std::uint64_t payload_bytes);
/// The frame with this head, as views of `rest` and `pixels`. `rest`: the payload after the head, at least
/// packet and memory; `pixels`: the image; null if the frame has none.
ClipFrame frame_of(const ClipFrameHead& head, std::uint32_t camera_id, std::span<const std::byte> rest,
                   const std::uint8_t* pixels);
/// Nullopt if the sizes are inconsistent or exceed the limits.
std::optional<ClipSetupParts> setup_in(std::span<const std::byte> payload);
/// Start of a setup's payload, before JSON and table.
std::array<std::byte, kClipSetupBytes> setup_head(std::uint32_t number, std::size_t json_bytes);
ClipIndexLine index_line_of(std::span<const std::byte, kClipIndexBytes> bytes);
/// Offset of the index in the file; nullopt if this is not a trailer.
std::optional<std::uint64_t> index_place_of(std::span<const std::byte, kClipTrailerBytes> trailer);

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t place);
std::uint64_t u64_at(std::span<const std::byte> bytes, std::size_t place);
void put_u32(std::span<std::byte> bytes, std::size_t place, std::uint32_t value);
void put_u64(std::span<std::byte> bytes, std::size_t place, std::uint64_t value);

/// CRC-32 as in gzip, continued from `sum`.
std::uint32_t clip_sum(std::span<const std::byte> bytes, std::uint32_t sum = 0);

/// Number of zero bytes after a payload, so that every block begins at a multiple of 8.
constexpr std::size_t clip_padding(std::uint64_t payload_bytes) {
  return static_cast<std::size_t>((8 - payload_bytes % 8) % 8);
}
/// Bytes of a block with its head and padding. `payload_bytes` must be below 2^63.
constexpr std::uint64_t clip_block_bytes(std::uint64_t payload_bytes) {
  return kClipBlockBytes + payload_bytes + clip_padding(payload_bytes);
}

/// Bytes of one plane: the pixels, or their low bits.
constexpr std::size_t clip_plane_bytes(PixelFormat format, int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
         static_cast<std::size_t>(bytes_per_pixel(format));
}
/// Bytes of all planes of an image.
inline std::size_t clip_image_bytes(const ImageView& image) {
  if (image.empty()) return 0;
  return clip_plane_bytes(image.format, image.width, image.height) * (image.to_low_bits != 0 ? 2 : 1);
}
/// Unix time in ns, as in block heads; clamped to +-9.2e18, 0 if `time_s` is not finite.
std::int64_t clip_ns(double time_s);

}  // namespace sslv
