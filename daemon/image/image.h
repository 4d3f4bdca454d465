// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace sslv {

/// How a camera's bytes lie. YUV is BT.601 full range (as JPEG has it).
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

/// An image somebody else owns. width and height in pixels; YUV 4:2:2 has an even width, Bayer both even.
struct ImageView {
  const std::uint8_t* data = nullptr;
  int width = 0, height = 0;
  std::ptrdiff_t stride_bytes = 0;
  PixelFormat format = PixelFormat::kMono8;
  /// Of a camera with more than 8 bits: so many bytes behind each sample lies what the 8 bits leave of it, in
  /// 256ths of a level. 0: nothing does. It holds for every part of the image, too.
  std::ptrdiff_t to_low_bits = 0;

  const std::uint8_t* row(int y) const { return data + y * stride_bytes; }
  bool empty() const { return data == nullptr; }
};

/// True when the size suits the format (see ImageView) and is within 2..16384 pixels.
bool is_valid_size(PixelFormat format, int width, int height);

/// An image with the duty to give its buffer back to the driver, done by the destructor. Move-only; making
/// and returning one allocates nothing.
class Image {
 public:
  /// Called once when the image is let go, from whatever thread that happens in.
  using Release = void (*)(void* owner, void* buffer) noexcept;

  Image() = default;
  Image(const ImageView& view, void* owner, void* buffer, Release release)
      : view_(view), owner_(owner), buffer_(buffer), release_(release) {}
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

  const ImageView& view() const { return view_; }
  /// From now on it is only this part of the same buffer.
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
