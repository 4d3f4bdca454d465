// SPDX-License-Identifier: Apache-2.0
#include "image/jpeg.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>

#include <turbojpeg.h>

namespace sslv {
namespace {

/// Maximum number of rows of a box whose bytes can be summed in 16 bits.
constexpr int kMaxBoxRows = 257;

int height_for(const ImageView& image, int width) {
  return std::max(1, (image.height * width + image.width / 2) / image.width);
}

void set_edges(std::vector<int>& edges, int count, int out_count) {
  edges.resize(static_cast<std::size_t>(out_count) + 1);
  for (int i = 0; i <= out_count; ++i) edges[static_cast<std::size_t>(i)] = i * count / out_count;
}

/// Position of red in each 2x2 block.
struct RedAt {
  int x, y;
};
RedAt red_at(PixelFormat format) {
  return {format == PixelFormat::kBayerGr8 || format == PixelFormat::kBayerBg8,
          format == PixelFormat::kBayerGb8 || format == PixelFormat::kBayerBg8};
}

/// Row y of the image at half its size: one RGB pixel for each 2x2 block.
void half_size_row(const ImageView& image, int y, std::uint8_t* out) {
  const RedAt red = red_at(image.format);
  const std::uint8_t* red_row = image.row(2 * y + red.y);
  const std::uint8_t* blue_row = image.row(2 * y + 1 - red.y);
  for (int x = 0; x < image.width; x += 2, out += 3) {
    out[0] = red_row[x + red.x];
    out[1] = static_cast<std::uint8_t>((red_row[x + 1 - red.x] + blue_row[x + red.x] + 1) / 2);
    out[2] = blue_row[x + 1 - red.x];
  }
}

/// Row y at full size as RGB; missing colours are averaged from the neighbours. Borders are mirrored, which
/// keeps the Bayer pattern.
void full_size_row(const ImageView& image, int y, std::uint8_t* out) {
  const RedAt red = red_at(image.format);
  const std::uint8_t* above = image.row(y > 0 ? y - 1 : 1);
  const std::uint8_t* here = image.row(y);
  const std::uint8_t* below = image.row(y + 1 < image.height ? y + 1 : image.height - 2);
  const bool red_row = y % 2 == red.y;
  for (int x = 0; x < image.width; ++x, out += 3) {
    const int left = x > 0 ? x - 1 : 1;
    const int right = x + 1 < image.width ? x + 1 : image.width - 2;
    const int beside = (here[left] + here[right] + 1) / 2;
    const int over = (above[x] + below[x] + 1) / 2;
    int own, green, other;  // own: red or blue, as in this row; other: the other of the two
    if ((x % 2 == red.x) == red_row) {
      own = here[x];
      green = (here[left] + here[right] + above[x] + below[x] + 2) / 4;
      other = (above[left] + above[right] + below[left] + below[right] + 2) / 4;
    } else {
      own = beside;
      green = here[x];
      other = over;
    }
    out[0] = static_cast<std::uint8_t>(red_row ? own : other);
    out[1] = static_cast<std::uint8_t>(green);
    out[2] = static_cast<std::uint8_t>(red_row ? other : own);
  }
}

}  // namespace

JpegEncoder::JpegEncoder() : handle_(tjInitCompress()) {
  if (handle_ == nullptr)
    throw std::runtime_error(std::string("no JPEG encoder: ") + tjGetErrorStr2(nullptr));
}

JpegEncoder::~JpegEncoder() {
  tjDestroy(handle_);
}

void JpegEncoder::fail() const {
  throw std::runtime_error(std::string("JPEG: ") + tjGetErrorStr2(handle_));
}

std::span<const std::uint8_t> JpegEncoder::encode(const ImageView& image, int max_width, int quality,
                                                  Chroma chroma) {
  const int width = std::clamp(max_width, 1, image.width);
  const int height = height_for(image, width);
  if (is_yuv422(image.format)) return encode_yuv422(image, width, height, quality);

  const bool grey = image.format == PixelFormat::kMono8;
  const int tj_format = grey ? TJPF_GRAY : image.format == PixelFormat::kBgr24 ? TJPF_BGR : TJPF_RGB;
  const int subsampling = grey ? TJSAMP_GRAY : chroma == Chroma::kFull ? TJSAMP_444 : TJSAMP_420;
  if (width == image.width && !is_bayer(image.format)) {
    return encode_packed(image.data, width, height, static_cast<int>(image.stride_bytes), tj_format,
                         subsampling, quality);
  }
  const int colors = grey ? 1 : 3;
  scaled_.resize(static_cast<std::size_t>(width) * height * colors);
  if (is_bayer(image.format)) {
    shrink_bayer(image, width, height);
  } else {
    set_edges(edges_, image.width, width);
    std::array<Channel, 3> channels{};
    for (int i = 0; i < colors; ++i) {
      channels[i] = {i, colors, image.width, scaled_.data() + i, colors, width * colors, width, &edges_};
    }
    shrink([&](int y) { return image.row(y); }, image.width * colors, image.height, height,
           std::span(channels).first(colors));
  }
  return encode_packed(scaled_.data(), width, height, width * colors, tj_format, subsampling, quality);
}

void JpegEncoder::shrink_bayer(const ImageView& image, int width, int height) {
  const bool half = 2 * width <= image.width;
  const int row_width = half ? image.width / 2 : image.width;
  line_.resize(static_cast<std::size_t>(row_width) * 3);
  set_edges(edges_, row_width, width);
  std::array<Channel, 3> channels{};
  for (int i = 0; i < 3; ++i) {
    channels[i] = {i, 3, row_width, scaled_.data() + i, 3, width * 3, width, &edges_};
  }
  shrink(
      [&](int y) -> const std::uint8_t* {
        half ? half_size_row(image, y, line_.data()) : full_size_row(image, y, line_.data());
        return line_.data();
      },
      row_width * 3, half ? image.height / 2 : image.height, height, channels);
}

std::span<const std::uint8_t> JpegEncoder::encode_yuv422(const ImageView& image, int width, int height,
                                                         int quality) {
  // Camera and JPEG define Y, U and V alike, so the planes are scaled and encoded without conversion.
  const int chroma_width = (width + 1) / 2;
  const int luma_stride = 2 * chroma_width;  // the library needs whole pairs of pixels, even if width is odd
  const std::size_t luma_size = static_cast<std::size_t>(luma_stride) * height;
  const std::size_t chroma_size = static_cast<std::size_t>(chroma_width) * height;
  scaled_.resize(luma_size + 2 * chroma_size);
  std::uint8_t* const y = scaled_.data();
  std::uint8_t* const u = y + luma_size;
  std::uint8_t* const v = u + chroma_size;
  set_edges(edges_, image.width, width);
  set_edges(chroma_edges_, image.width / 2, chroma_width);
  const int y_offset = image.format == PixelFormat::kUyvy ? 1 : 0;
  const int u_offset = 1 - y_offset;
  const std::array channels{
      Channel{y_offset, 2, image.width, y, 1, luma_stride, width, &edges_},
      Channel{u_offset, 4, image.width / 2, u, 1, chroma_width, chroma_width, &chroma_edges_},
      Channel{u_offset + 2, 4, image.width / 2, v, 1, chroma_width, chroma_width, &chroma_edges_},
  };
  shrink([&](int row) { return image.row(row); }, image.width * 2, image.height, height, channels);
  if (luma_stride > width) {
    for (std::uint8_t* end = y + width; end < u; end += luma_stride) *end = end[-1];
  }

  reserve_jpeg(width, height, TJSAMP_422);
  const std::array<const unsigned char*, 3> planes{y, u, v};
  unsigned char* out = jpeg_.data();
  unsigned long size = jpeg_.size();
  if (tjCompressFromYUVPlanes(handle_, const_cast<const unsigned char**>(planes.data()), width, nullptr,
                              height, TJSAMP_422, &out, &size, quality, TJFLAG_NOREALLOC) != 0) {
    fail();
  }
  return {jpeg_.data(), size};
}

std::span<const std::uint8_t> JpegEncoder::encode_packed(const std::uint8_t* data, int width, int height,
                                                         int stride_bytes, int tj_format, int subsampling,
                                                         int quality) {
  reserve_jpeg(width, height, subsampling);
  unsigned char* out = jpeg_.data();
  unsigned long size = jpeg_.size();
  if (tjCompress2(handle_, data, width, stride_bytes, height, tj_format, &out, &size, subsampling, quality,
                  TJFLAG_NOREALLOC) != 0) {
    fail();
  }
  return {jpeg_.data(), size};
}

void JpegEncoder::reserve_jpeg(int width, int height, int subsampling) {
  jpeg_.resize(std::max<std::size_t>(jpeg_.size(), tjBufSize(width, height, subsampling)));
}

/// Each result is the mean of a box of whole pixels; boxes do not overlap. The rows of a box are summed
/// first, byte by byte regardless of the channel, so that the compiler can vectorise the sum.
template <class Row>
void JpegEncoder::shrink(Row&& row, int row_bytes, int height, int out_height,
                         std::span<const Channel> channels) {
  sums_.resize(static_cast<std::size_t>(row_bytes));
  for (int out_y = 0; out_y < out_height; ++out_y) {
    const int y_begin = out_y * height / out_height;
    const int y_end = std::max(y_begin + 1, (out_y + 1) * height / out_height);
    const int y_step = (y_end - y_begin + kMaxBoxRows - 1) / kMaxBoxRows;
    std::fill(sums_.begin(), sums_.end(), std::uint16_t{0});
    unsigned rows = 0;
    for (int y = y_begin; y < y_end; y += y_step, ++rows) {
      const std::uint8_t* bytes = row(y);
      std::uint16_t* sums = sums_.data();
      for (int i = 0; i < row_bytes; ++i) sums[i] = static_cast<std::uint16_t>(sums[i] + bytes[i]);
    }
    for (const Channel& channel : channels) {
      // Boxes are `narrow` or `narrow` + 1 samples wide: two reciprocals in 32-bit fixed point replace the
      // divisions.
      const int narrow = channel.count / channel.out_count;
      const std::array<std::uint64_t, 2> reciprocal{
          (1ULL << 32) / (rows * static_cast<unsigned>(narrow)),
          (1ULL << 32) / (rows * static_cast<unsigned>(narrow + 1))};
      const int* edges = channel.edges->data();
      std::uint8_t* out = channel.out + static_cast<std::ptrdiff_t>(out_y) * channel.out_stride;
      if (rows == 1 && channel.count == channel.out_count) {  // nothing to average
        const std::uint16_t* sample = sums_.data() + channel.offset;
        for (int x = 0; x < channel.count; ++x, sample += channel.step, out += channel.out_step) {
          *out = static_cast<std::uint8_t>(*sample);
        }
        continue;
      }
      for (int out_x = 0; out_x < channel.out_count; ++out_x, out += channel.out_step) {
        const std::uint16_t* sums = sums_.data() + channel.offset + edges[out_x] * channel.step;
        const int width = edges[out_x + 1] - edges[out_x];
        std::uint32_t sum = 0;
        for (int x = 0; x < width; ++x, sums += channel.step) sum += *sums;
        *out = static_cast<std::uint8_t>((sum * reciprocal[width != narrow] + (1ULL << 31)) >> 32);
      }
    }
  }
}

}  // namespace sslv
