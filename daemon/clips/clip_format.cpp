// SPDX-License-Identifier: Apache-2.0
#include "clips/clip_format.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <zlib.h>

namespace sslv {
namespace {

// Bits of a frame's flags.
constexpr std::uint32_t kHasCameraTime = 1, kHasSigma = 2, kIsByPtp = 4, kIsDeep = 8;
// Bits of an index line's flags.
constexpr std::uint32_t kHasMemory = 1, kIsWhole = 2;

/// Pixel formats, indexed by their numbers in the file. The numbers stay the same when the enum in
/// image/image.h changes.
constexpr std::array kFormats{PixelFormat::kUyvy,     PixelFormat::kYuyv,     PixelFormat::kRgb24,
                              PixelFormat::kBgr24,    PixelFormat::kMono8,    PixelFormat::kBayerRg8,
                              PixelFormat::kBayerGr8, PixelFormat::kBayerGb8, PixelFormat::kBayerBg8};

void put_f64(std::span<std::byte> bytes, std::size_t place, double value) {
  put_u64(bytes, place, std::bit_cast<std::uint64_t>(value));
}

double f64_at(std::span<const std::byte> bytes, std::size_t place) {
  return std::bit_cast<double>(u64_at(bytes, place));
}

int i32_at(std::span<const std::byte> bytes, std::size_t place) {
  return static_cast<int>(u32_at(bytes, place));
}

void put_text(std::span<std::byte> bytes, std::string_view text) {
  std::ranges::transform(text, bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
}

bool is_text(std::span<const std::byte> bytes, std::string_view text) {
  return std::ranges::equal(bytes, text, {}, {}, [](char c) { return static_cast<std::byte>(c); });
}

}  // namespace

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t place) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8U | std::to_integer<std::uint32_t>(bytes[place + i]);
  return value;
}

std::uint64_t u64_at(std::span<const std::byte> bytes, std::size_t place) {
  return u32_at(bytes, place) | std::uint64_t{u32_at(bytes, place + 4)} << 32U;
}

void put_u32(std::span<std::byte> bytes, std::size_t place, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[place + i] = static_cast<std::byte>(value >> 8 * i);
}

void put_u64(std::span<std::byte> bytes, std::size_t place, std::uint64_t value) {
  for (std::size_t i = 0; i < 8; ++i) bytes[place + i] = static_cast<std::byte>(value >> 8 * i);
}

std::uint32_t clip_sum(std::span<const std::byte> bytes, std::uint32_t sum) {
  if (bytes.empty()) return sum;  // zlib returns the initial value for a null pointer, regardless of `sum`
  return static_cast<std::uint32_t>(crc32_z(sum, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

void leave_out_bad_times(CaptureTimes& times) {
  for (std::optional<double>* time_s : {&times.t_capture_camera_s, &times.t_capture_sigma_s}) {
    if (*time_s && !std::isfinite(**time_s)) time_s->reset();
  }
}

std::array<std::byte, kClipHeadBytes> clip_head() {
  std::array<std::byte, kClipHeadBytes> out{};
  put_text(out, kClipMagic);
  put_u32(out, kClipMagic.size(), kClipVersion);
  return out;
}

std::array<std::byte, kClipTrailerBytes> clip_trailer(std::uint64_t index_place) {
  std::array<std::byte, kClipTrailerBytes> out{};
  put_u64(out, 0, index_place);
  put_text(std::span(out).subspan(8), kClipTrailerMagic);
  return out;
}

std::optional<std::uint64_t> index_place_of(std::span<const std::byte, kClipTrailerBytes> trailer) {
  if (!is_text(trailer.subspan(8), kClipTrailerMagic)) return std::nullopt;
  return u64_at(trailer, 0);
}

std::array<std::byte, kClipBlockBytes> encoded(const ClipBlockHead& head) {
  std::array<std::byte, kClipBlockBytes> out{};
  put_u32(out, 0, head.type);
  put_u32(out, 4, head.camera_id);
  put_u64(out, 8, head.bytes);
  put_u64(out, 16, static_cast<std::uint64_t>(head.time_ns));
  put_u32(out, 24, head.sum);
  put_u32(out, 28, clip_sum(std::span(out).first(28)));
  return out;
}

std::optional<ClipBlockHead> block_head_of(std::span<const std::byte, kClipBlockBytes> bytes) {
  if (u32_at(bytes, 28) != clip_sum(bytes.first(28))) return std::nullopt;
  return ClipBlockHead{.type = u32_at(bytes, 0),
                       .camera_id = u32_at(bytes, 4),
                       .bytes = u64_at(bytes, 8),
                       .time_ns = static_cast<std::int64_t>(u64_at(bytes, 16)),
                       .sum = u32_at(bytes, 24)};
}

std::array<std::byte, kClipFrameBytes> encoded(const ClipFrameHead& head) {
  const CaptureTimes& times = head.info.times;
  const WholePicture& whole = head.info.whole;
  std::array<std::byte, kClipFrameBytes> out{};
  put_u32(out, 0, head.info.number);
  put_u32(out, 4, head.setup);
  put_f64(out, 8, times.t_capture_s);
  put_f64(out, 16, times.t_capture_camera_s.value_or(0));
  put_f64(out, 24, times.t_capture_sigma_s.value_or(0));
  put_u32(out, 32,
          (times.t_capture_camera_s ? kHasCameraTime : 0) | (times.t_capture_sigma_s ? kHasSigma : 0) |
              (times.is_by_ptp ? kIsByPtp : 0) | (head.is_deep ? kIsDeep : 0));
  put_u32(out, 36, static_cast<std::uint32_t>(std::ranges::find(kFormats, head.format) - kFormats.begin()));
  put_u32(out, 40, static_cast<std::uint32_t>(head.width));
  put_u32(out, 44, static_cast<std::uint32_t>(head.height));
  put_u32(out, 48, static_cast<std::uint32_t>(whole.width));
  put_u32(out, 52, static_cast<std::uint32_t>(whole.height));
  put_u32(out, 56, static_cast<std::uint32_t>(whole.x));
  put_u32(out, 60, static_cast<std::uint32_t>(whole.y));
  put_u64(out, 72, head.packet_bytes);
  put_u64(out, 80, head.memory_bytes);
  put_u64(out, 96, head.image_bytes);
  put_u32(out, 124, clip_sum(std::span(out).first(124)));
  return out;
}

std::optional<ClipFrameHead> frame_head_of(std::span<const std::byte, kClipFrameBytes> bytes,
                                           std::uint64_t payload_bytes) {
  if (u32_at(bytes, 124) != clip_sum(bytes.first(124))) return std::nullopt;
  ClipFrameHead head;
  head.info.number = u32_at(bytes, 0);
  head.setup = u32_at(bytes, 4);
  const std::uint32_t flags = u32_at(bytes, 32);
  CaptureTimes& times = head.info.times;
  times.t_capture_s = f64_at(bytes, 8);
  if ((flags & kHasCameraTime) != 0) times.t_capture_camera_s = f64_at(bytes, 16);
  if ((flags & kHasSigma) != 0) times.t_capture_sigma_s = f64_at(bytes, 24);
  times.is_by_ptp = (flags & kIsByPtp) != 0;
  head.is_deep = (flags & kIsDeep) != 0;
  for (const double time_s :
       {times.t_capture_s, times.t_capture_camera_s.value_or(0), times.t_capture_sigma_s.value_or(0)}) {
    if (!std::isfinite(time_s)) return std::nullopt;
  }
  const std::uint32_t format = u32_at(bytes, 36);
  if (format >= kFormats.size()) return std::nullopt;
  head.format = kFormats[format];
  head.width = i32_at(bytes, 40);
  head.height = i32_at(bytes, 44);
  WholePicture& whole = head.info.whole;
  whole = {.width = i32_at(bytes, 48),
           .height = i32_at(bytes, 52),
           .x = i32_at(bytes, 56),
           .y = i32_at(bytes, 60)};
  // Bounds the larger image's size and the position in it, so that their sums cannot overflow.
  constexpr int kMaxSide = 1 << 20;
  for (const int number : {whole.width, whole.height, whole.x, whole.y}) {
    if (number < 0 || number > kMaxSide) return std::nullopt;
  }
  head.packet_bytes = u64_at(bytes, 72);
  head.memory_bytes = u64_at(bytes, 80);
  head.image_bytes = u64_at(bytes, 96);
  // Earlier versions could store parts of an image: side of a square; size of the bitmap of the stored
  // squares.
  const int square_px = i32_at(bytes, 64);
  const std::uint64_t map_bytes = u64_at(bytes, 88);
  head.is_in_parts = square_px != 0;

  std::uint64_t rest = payload_bytes;
  for (const std::uint64_t part :
       {std::uint64_t{kClipFrameBytes}, head.packet_bytes, head.memory_bytes, map_bytes, head.image_bytes}) {
    if (part > rest) return std::nullopt;
    rest -= part;
  }
  if (rest != 0) return std::nullopt;
  if (head.packet_bytes > kMaxClipPacketBytes || head.memory_bytes > kMaxClipMemoryBytes) return std::nullopt;
  const bool has_size = head.width != 0 || head.height != 0;
  if (has_size && !is_valid_size(head.format, head.width, head.height)) return std::nullopt;
  const std::uint64_t whole_bytes =
      has_size ? clip_plane_bytes(head.format, head.width, head.height) * (head.is_deep ? 2 : 1) : 0;
  constexpr std::uint64_t kMaxMapBytes = 1 << 16;
  if (head.is_in_parts)
    return map_bytes <= kMaxMapBytes && head.image_bytes <= whole_bytes ? std::optional(head) : std::nullopt;
  return map_bytes == 0 && head.image_bytes == whole_bytes ? std::optional(head) : std::nullopt;
}

ClipFrame frame_of(const ClipFrameHead& head, std::uint32_t camera_id, std::span<const std::byte> rest,
                   const std::uint8_t* pixels) {
  ClipFrame out{.info = head.info, .setup = head.setup};
  out.info.camera_id = camera_id;
  out.packet = rest.first(static_cast<std::size_t>(head.packet_bytes));
  out.memory = rest.subspan(out.packet.size(), static_cast<std::size_t>(head.memory_bytes));
  if (pixels == nullptr) return out;
  const auto plane_bytes =
      static_cast<std::ptrdiff_t>(clip_plane_bytes(head.format, head.width, head.height));
  out.image = {.data = pixels,
               .width = head.width,
               .height = head.height,
               .stride_bytes = plane_bytes / head.height,
               .format = head.format,
               .to_low_bits = head.is_deep ? plane_bytes : 0};
  return out;
}

std::optional<ClipSetupParts> setup_in(std::span<const std::byte> payload) {
  if (payload.size() < kClipSetupBytes) return std::nullopt;
  const std::uint64_t json_bytes = u64_at(payload, 8);
  const auto rest = payload.subspan(kClipSetupBytes);
  if (json_bytes > rest.size() || json_bytes > kMaxClipJsonBytes ||
      rest.size() - json_bytes > kMaxClipTableBytes)
    return std::nullopt;
  const auto json = rest.first(static_cast<std::size_t>(json_bytes));
  return ClipSetupParts{u32_at(payload, 0), json, rest.subspan(json.size())};
}

std::array<std::byte, kClipSetupBytes> setup_head(std::uint32_t number, std::size_t json_bytes) {
  std::array<std::byte, kClipSetupBytes> out{};
  put_u32(out, 0, number);
  put_u64(out, 8, json_bytes);
  return out;
}

std::int64_t clip_ns(double time_s) {
  constexpr double kMax_ns = 9.2e18;
  return std::isfinite(time_s) ? static_cast<std::int64_t>(std::clamp(time_s * 1e9, -kMax_ns, kMax_ns)) : 0;
}

std::array<std::byte, kClipIndexBytes> encoded(const ClipIndexLine& line) {
  std::array<std::byte, kClipIndexBytes> out{};
  put_u64(out, 0, line.place);
  put_u64(out, 8, line.bytes);
  put_f64(out, 16, line.t_capture_s);
  put_u32(out, 24, line.type);
  put_u32(out, 28, line.camera_id);
  put_u32(out, 32, line.number);
  put_u32(out, 36, (line.has_memory ? kHasMemory : 0) | (line.is_whole ? kIsWhole : 0));
  return out;
}

ClipIndexLine index_line_of(std::span<const std::byte, kClipIndexBytes> bytes) {
  const std::uint32_t flags = u32_at(bytes, 36);
  return {.place = u64_at(bytes, 0),
          .bytes = u64_at(bytes, 8),
          .t_capture_s = f64_at(bytes, 16),
          .type = u32_at(bytes, 24),
          .camera_id = u32_at(bytes, 28),
          .number = u32_at(bytes, 32),
          .has_memory = (flags & kHasMemory) != 0,
          .is_whole = (flags & kIsWhole) != 0};
}

}  // namespace sslv
