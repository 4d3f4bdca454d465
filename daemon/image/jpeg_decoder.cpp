// SPDX-License-Identifier: Apache-2.0
#include "image/jpeg_decoder.h"

#include <array>
#include <cstddef>
#include <stdexcept>
#include <string_view>

#include <turbojpeg.h>

namespace sslv {

namespace {

/// Many webcams send some bytes between an image and its end mark.
bool is_harmless(std::string_view problem) {
  return problem.find("extraneous bytes before marker 0xd9") != std::string_view::npos;
}

}  // namespace

JpegDecoder::JpegDecoder() {
  start();
}

JpegDecoder::~JpegDecoder() {
  tjDestroy(handle_);
}

void JpegDecoder::start() {
  if (handle_ != nullptr) tjDestroy(handle_);
  handle_ = tjInitDecompress();
  if (handle_ == nullptr)
    throw std::runtime_error(std::string("no JPEG decoder: ") + tjGetErrorStr2(nullptr));
}

/// Recreates the library's decoder, which keeps the state of the failed image and would misread the next one.
void JpegDecoder::give_up(std::string& problem) {
  problem = tjGetErrorStr2(handle_);
  start();
}

ImageView JpegDecoder::layout(std::span<const std::uint8_t> jpeg, std::string& problem) {
  layout_ = {};
  int width = 0, height = 0, color_space = 0;
  if (tjDecompressHeader3(handle_, jpeg.data(), jpeg.size(), &width, &height, &subsampling_, &color_space) !=
      0) {
    give_up(problem);
    return layout_;
  }
  const bool halved = subsampling_ == TJSAMP_422 || subsampling_ == TJSAMP_420;
  const bool as_yuv = color_space == TJCS_YCbCr && halved && is_valid_size(PixelFormat::kUyvy, width, height);
  const PixelFormat format = as_yuv ? PixelFormat::kUyvy : PixelFormat::kRgb24;
  if (!is_valid_size(format, width, height)) {
    problem = "an image of " + std::to_string(width) + 'x' + std::to_string(height) + " pixels";
    return layout_;
  }
  layout_ = {nullptr, width, height, std::ptrdiff_t{width} * bytes_per_pixel(format), format};
  return layout_;
}

bool JpegDecoder::decode(std::span<const std::uint8_t> jpeg, std::uint8_t* out, std::string& problem) {
  const bool sound = layout_.format == PixelFormat::kUyvy
                         ? decode_uyvy(jpeg, out)
                         : tjDecompress2(handle_, jpeg.data(), jpeg.size(), out, layout_.width, 0,
                                         layout_.height, TJPF_RGB, 0) == 0;
  if (sound || is_harmless(tjGetErrorStr2(handle_))) return true;
  give_up(problem);
  return false;
}

/// Interleaves the JPEG's planes without conversion, so no colours have to be interpolated.
bool JpegDecoder::decode_uyvy(std::span<const std::uint8_t> jpeg, std::uint8_t* out) {
  const int width = layout_.width, height = layout_.height;
  std::array<std::uint8_t*, 3> planes{};
  std::array<std::size_t, 4> starts{};
  for (int i = 0; i < 3; ++i) {
    starts[static_cast<std::size_t>(i) + 1] =
        starts[static_cast<std::size_t>(i)] + tjPlaneSizeYUV(i, width, 0, height, subsampling_);
  }
  planes_.resize(starts[3]);
  for (std::size_t i = 0; i < 3; ++i) planes[i] = planes_.data() + starts[i];
  const bool sound = tjDecompressToYUVPlanes(handle_, jpeg.data(), jpeg.size(), planes.data(), width, nullptr,
                                             height, 0) == 0;

  const int y_stride = tjPlaneWidth(0, width, subsampling_), uv_stride = tjPlaneWidth(1, width, subsampling_);
  const int rows_of_color = subsampling_ == TJSAMP_420 ? 2 : 1;
  for (int row = 0; row < height; ++row) {
    const std::uint8_t* y = planes[0] + std::ptrdiff_t{row} * y_stride;
    const std::uint8_t* u = planes[1] + std::ptrdiff_t{row / rows_of_color} * uv_stride;
    const std::uint8_t* v = planes[2] + std::ptrdiff_t{row / rows_of_color} * uv_stride;
    for (int x = 0; x < width / 2; ++x, y += 2, out += 4) {
      out[0] = u[x];
      out[1] = y[0];
      out[2] = v[x];
      out[3] = y[1];
    }
  }
  return sound;
}

}  // namespace sslv
