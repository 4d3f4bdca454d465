// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sslv {

/// How finely a JPEG keeps the colour of RGB and Bayer images: at half the size, as photographs have it, or
/// in full for drawings, whose edges would bleed otherwise.
enum class Chroma : std::uint8_t { kHalved, kFull };

/// Makes JPEGs for viewers. Keeps its buffers, so use one for many images; one thread at a time.
class JpegEncoder {
 public:
  JpegEncoder();
  ~JpegEncoder();
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;

  /// The image as a JPEG file in colour (mono8: in grey), scaled down before encoding to at most
  /// `max_width` pixels, at least 1; never scaled up. `quality` 1..100. The bytes hold until the next call.
  /// Throws std::runtime_error with the library's reason for an image it does not take.
  std::span<const std::uint8_t> encode(const ImageView& image, int max_width, int quality,
                                       Chroma chroma = Chroma::kHalved);

 private:
  /// One colour of the rows to be scaled and the plane it goes to.
  struct Channel {
    int offset, step, count;  // where its samples lie in a row, bytes
    std::uint8_t* out;
    int out_step, out_stride, out_count;
    const std::vector<int>* edges;  // out_count + 1 sample numbers: where the boxes to be averaged meet
  };
  template <class Row>
  void shrink(Row&& row, int row_bytes, int height, int out_height, std::span<const Channel> channels);

  std::span<const std::uint8_t> encode_packed(const std::uint8_t* data, int width, int height,
                                              int stride_bytes, int tj_format, int subsampling, int quality);
  std::span<const std::uint8_t> encode_yuv422(const ImageView& image, int width, int height, int quality);
  void shrink_bayer(const ImageView& image, int width, int height);
  void reserve_jpeg(int width, int height, int subsampling);
  [[noreturn]] void fail() const;

  void* handle_;
  std::vector<std::uint8_t> jpeg_, scaled_, line_;
  std::vector<std::uint16_t> sums_;
  std::vector<int> edges_, chroma_edges_;
};

}  // namespace sslv
