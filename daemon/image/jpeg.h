// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sslv {

/// Colour resolution of JPEGs made from RGB and Bayer images: half, as usual for photographs, or full for
/// drawings, whose edges would bleed otherwise.
enum class Chroma : std::uint8_t { kHalved, kFull };

/// Encodes JPEGs for viewers. Reuses its buffers, so use one encoder for many images; one thread at a time.
class JpegEncoder {
 public:
  JpegEncoder();
  ~JpegEncoder();
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;

  /// Encodes the image in colour (mono8: grey). Images wider than `max_width` pixels (at least 1) are scaled
  /// down first. `quality`: 1..100. The bytes are valid until the next call. Throws std::runtime_error with
  /// the library's reason if the library refuses the image.
  std::span<const std::uint8_t> encode(const ImageView& image, int max_width, int quality,
                                       Chroma chroma = Chroma::kHalved);

 private:
  /// A colour channel of the rows to be scaled, and its output plane.
  struct Channel {
    int offset, step, count;  // first byte and byte distance of the samples in a row; their number
    std::uint8_t* out;
    int out_step, out_stride, out_count;
    const std::vector<int>* edges;  // out_count + 1 sample indices: limits of the averaged boxes
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
