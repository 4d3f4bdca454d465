// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a clip's bytes lie, for its writer and its reader. docs/recording.md describes the same for authors of
// tools: keep both alike. All numbers are little-endian.

#include "clips/clip.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace sslv {

/// Like PNG's: a byte that is no ASCII, and line ends that a transfer as text would change.
inline constexpr std::string_view kClipMagic = "\x89SSL_CLIP\r\n\x1a";
inline constexpr std::uint32_t kClipVersion = 1;
inline constexpr std::size_t kClipHeadBytes = 16;     // of the file
inline constexpr std::size_t kClipBlockBytes = 32;    // before each block's payload
inline constexpr std::size_t kClipFrameBytes = 128;   // at the beginning of a frame's payload
inline constexpr std::size_t kClipSetupBytes = 16;    // at the beginning of a setup's payload
inline constexpr std::size_t kClipMissingBytes = 8;   // the whole payload
inline constexpr std::size_t kClipIndexBytes = 40;    // of each block that the index names
inline constexpr std::size_t kClipTrailerBytes = 16;  // at the end of the file
inline constexpr std::string_view kClipTrailerMagic = "SSL_CEND";

/// Files may be sparse: what they say of sizes costs their authors nothing. With these limits, for writers as
/// for readers, no file takes more than 64 MB of memory while it is opened and its frames are looked at, nor
/// while it is opened and a setup is read. A replay needs a frame and its setup at once, and more.
inline constexpr std::uint64_t kMaxClipBlocks = 1 << 19;  // eight cameras at 75 Hz for 14 minutes
inline constexpr std::size_t kMaxClipCameras = 256;
inline constexpr std::size_t kMaxClipSetups = 16384;
inline constexpr std::size_t kMaxClipEvents = 4096;
/// Blocks that are left to what comes when no more frames do.
inline constexpr std::uint64_t kClipEndBlocks = kMaxClipEvents + kMaxClipCameras + 8;
/// Of a setup's JSON, whose values take up to twenty times the memory of their text.
inline constexpr std::size_t kMaxClipJsonBytes = std::size_t{1} << 20U;
/// Of the JSON of an event, or of what the clip says about itself; of all of them together.
inline constexpr std::size_t kMaxClipEventBytes = std::size_t{64} << 10U;
inline constexpr std::size_t kMaxClipEventBytesInAll = std::size_t{1} << 20U;
inline constexpr std::size_t kMaxClipTableBytes = std::size_t{20} << 20U;  // 8 bits a colour: 16 MiB
inline constexpr std::size_t kMaxClipPacketBytes = 65'507;                 // the largest datagram
inline constexpr std::size_t kMaxClipMemoryBytes = std::size_t{1} << 20U;
inline constexpr std::size_t kMaxClipImageBytes = std::size_t{48} << 20U;  // 25 megapixels of 2 bytes
/// Of an image that a reader has in memory, and what it keeps of all frames: of a clip of very many frames,
/// images may only be smaller. Such a clip of larger ones would have terabytes.
inline constexpr std::size_t kMaxClipBytesInMemory = 52'000'000;

enum class ClipBlock : std::uint32_t { kAbout = 1, kSetup, kFrame, kEvent, kMissing, kIndex };

struct ClipBlockHead {
  std::uint32_t type = 0;  // ClipBlock, or one that a later program wrote
  std::uint32_t camera_id = 0;
  std::uint64_t bytes = 0;   // of the payload
  std::int64_t time_ns = 0;  // Unix; 0: it has none
  std::uint32_t sum = 0;     // CRC-32 of the payload
};

/// A frame's payload begins with this; then come packet, memory and image.
struct ClipFrameHead {
  FrameInfo info{};         // all but the camera's id, which the block has, and arrived_ns
  std::uint32_t setup = 0;  // number
  PixelFormat format = PixelFormat::kMono8;
  int width = 0, height = 0;  // px; 0: without an image
  bool is_deep = false;       // low bits follow the pixels
  std::uint64_t packet_bytes = 0, memory_bytes = 0, image_bytes = 0;
  /// Earlier versions could keep only parts of an image. They are passed over: such a frame has no image.
  bool is_in_parts = false;

  bool has_image() const { return width != 0 && !is_in_parts; }
};

/// What a setup's payload holds.
struct ClipSetupParts {
  std::uint32_t number = 0;
  std::span<const std::byte> json, table;
};

/// What the index says of a block.
struct ClipIndexLine {
  std::uint64_t place = 0;  // in the file
  std::uint64_t bytes = 0;  // of the payload
  double t_capture_s = 0;   // of a frame; 0 for others
  std::uint32_t type = 0, camera_id = 0;
  std::uint32_t number = 0;  // of a frame or setup; 0 for others
  bool has_memory = false, is_whole = false;
};

/// Times that may be missing are missing where they are no numbers: a frame must not be lost for them.
void leave_out_bad_times(CaptureTimes& times);

std::array<std::byte, kClipHeadBytes> clip_head();
std::array<std::byte, kClipBlockBytes> encoded(const ClipBlockHead& head);
std::array<std::byte, kClipFrameBytes> encoded(const ClipFrameHead& head);
std::array<std::byte, kClipIndexBytes> encoded(const ClipIndexLine& line);
std::array<std::byte, kClipTrailerBytes> clip_trailer(std::uint64_t index_place);

/// None where the bytes are damaged.
std::optional<ClipBlockHead> block_head_of(std::span<const std::byte, kClipBlockBytes> bytes);
/// None where the bytes are damaged, or cannot be a payload of `payload_bytes`. All sizes in it fit each
/// other; but its image may be larger than kMaxClipImageBytes.
std::optional<ClipFrameHead> frame_head_of(std::span<const std::byte, kClipFrameBytes> bytes,
                                           std::uint64_t payload_bytes);
/// The frame of a head. `rest`: what follows it in the payload, at least packet and memory; `pixels`: its
/// image, null where it has none. All in the frame lies there.
ClipFrame frame_of(const ClipFrameHead& head, std::uint32_t camera_id, std::span<const std::byte> rest,
                   const std::uint8_t* pixels);
/// None where the sizes do not fit each other, or are beyond the limits.
std::optional<ClipSetupParts> setup_in(std::span<const std::byte> payload);
/// What stands before JSON and table in a setup's payload.
std::array<std::byte, kClipSetupBytes> setup_head(std::uint32_t number, std::size_t json_bytes);
ClipIndexLine index_line_of(std::span<const std::byte, kClipIndexBytes> bytes);
/// Place of the index; none: this is no trailer.
std::optional<std::uint64_t> index_place_of(std::span<const std::byte, kClipTrailerBytes> trailer);

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t place);
std::uint64_t u64_at(std::span<const std::byte> bytes, std::size_t place);
void put_u32(std::span<std::byte> bytes, std::size_t place, std::uint32_t value);
void put_u64(std::span<std::byte> bytes, std::size_t place, std::uint64_t value);

/// CRC-32 as gzip has it, going on from `sum`.
std::uint32_t clip_sum(std::span<const std::byte> bytes, std::uint32_t sum = 0);

/// Zeros behind a payload, so that every block begins at a multiple of 8.
constexpr std::size_t clip_padding(std::uint64_t payload_bytes) {
  return static_cast<std::size_t>((8 - payload_bytes % 8) % 8);
}
/// Bytes of a block with its head and padding. `payload_bytes` must be below 2^63.
constexpr std::uint64_t clip_block_bytes(std::uint64_t payload_bytes) {
  return kClipBlockBytes + payload_bytes + clip_padding(payload_bytes);
}

/// The size of one plane: the pixels, or their low bits.
constexpr std::size_t clip_plane_bytes(PixelFormat format, int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
         static_cast<std::size_t>(bytes_per_pixel(format));
}
/// Of all planes of a frame's image.
inline std::size_t clip_image_bytes(const ImageView& image) {
  if (image.empty()) return 0;
  return clip_plane_bytes(image.format, image.width, image.height) * (image.to_low_bits != 0 ? 2 : 1);
}
/// On the clock of block heads; 0 where it is no time.
std::int64_t clip_ns(double time_s);

}  // namespace sslv
