// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace sslv {

/// Memory layout of pixels. YUV is BT.601 full range, as in JPEG.
enum class PixelFormat : std::uint8_t {
  kUyvy,  // U Y V Y for two pixels
  kYuyv,  // Y U Y V for two pixels
  kRgb24,
  kBgr24,
  kMono8,
  kBayerRg8,  // named after the first two pixels of the first row: R G / G B
  kBayerGr8,  // G R / B G
  kBayerGb8,  // G B / R G
  kBayerBg8,  // B G / G R
};

/// "uyvy", "rgb24", "bayer_rg8"...: the names used in settings and on the command line.
std::string_view name_of(PixelFormat format);
std::optional<PixelFormat> pixel_format_named(std::string_view name);

constexpr bool is_bayer(PixelFormat format) {
  return format >= PixelFormat::kBayerRg8;
}
constexpr bool is_yuv422(PixelFormat format) {
  return format <= PixelFormat::kYuyv;
}

constexpr int bytes_per_pixel(PixelFormat format) {
  return is_yuv422(format) ? 2 : format == PixelFormat::kRgb24 || format == PixelFormat::kBgr24 ? 3 : 1;
}

/// View of an image that another object owns. width and height in pixels. Images in YUV 4:2:2 have an even
/// width; Bayer images have an even width and height.
struct ImageView {
  const std::uint8_t* data = nullptr;
  int width = 0, height = 0;
  std::ptrdiff_t stride_bytes = 0;
  PixelFormat format = PixelFormat::kMono8;
  /// For cameras with more than 8 bits: offset in bytes from each sample to its low bits, in 256ths of a
  /// level. 0: no low bits. Valid for every part of the image.
  std::ptrdiff_t to_low_bits = 0;

  /// First byte of row `y`.
  const std::uint8_t* row(int y) const { return data + y * stride_bytes; }
  /// True if there is no image.
  bool empty() const { return data == nullptr; }
};

/// True when the size suits the format (see ImageView) and is within 2..16384 pixels.
bool is_valid_size(PixelFormat format, int width, int height);

/// Owns an image's buffer and returns it to the driver in the destructor. Move-only; creating and releasing
/// an image allocates no memory.
class Image {
 public:
  /// Called once when the image is released, from any thread.
  using Release = void (*)(void* owner, void* buffer) noexcept;

  Image() = default;
  /// The destructor calls release(owner, buffer). `view` lies in the buffer.
  Image(const ImageView& view, void* owner, void* buffer, Release release)
      : view_(view), owner_(owner), buffer_(buffer), release_(release) {}
  /// Leaves `other` without an image.
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(Image&& other) noexcept {
    Image old(std::move(*this));
    swap(other);
    return *this;
  }
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;
  ~Image() {
    if (release_ != nullptr) release_(owner_, buffer_);
  }

  /// Valid until the image is released.
  const ImageView& view() const { return view_; }
  /// Restricts the view to this part of the same buffer.
  void narrow_to(const ImageView& part) { view_ = part; }

 private:
  void swap(Image& other) noexcept {
    std::swap(view_, other.view_);
    std::swap(owner_, other.owner_);
    std::swap(buffer_, other.buffer_);
    std::swap(release_, other.release_);
  }

  ImageView view_;
  void* owner_ = nullptr;
  void* buffer_ = nullptr;
  Release release_ = nullptr;
};

}  // namespace sslv
