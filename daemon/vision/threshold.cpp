// SPDX-License-Identifier: Apache-2.0
#include "vision/threshold.h"

#include <algorithm>

namespace sslv {
namespace {

/// kLuma: position of the first Y in the four bytes of two pixels; it determines the positions of U and V.
template <int kLuma>
void label_yuv422(const Lut& lut, const std::uint8_t* in, Label* out, int width) {
  constexpr int kU = kLuma == 1 ? 0 : 1, kV = kU + 2;
  for (int x = 0; x < width; x += 2, in += 4) {
    out[x] = lut.of_yuv(in[kLuma], in[kU], in[kV]);
    out[x + 1] = lut.of_yuv(in[kLuma + 2], in[kU], in[kV]);
  }
}

template <int kRed>
void label_rgb(const Lut& lut, const std::uint8_t* in, Label* out, int width) {
  for (int x = 0; x < width; ++x, in += 3) out[x] = lut.of_rgb(in[kRed], in[1], in[2 - kRed]);
}

void label_mono(const Lut& lut, const std::uint8_t* in, Label* out, int width) {
  for (int x = 0; x < width; ++x) out[x] = lut.of_yuv(in[x], 128, 128);
}

/// kRed: position of red in the quad (0 1 / 2 3); blue is at the opposite corner.
template <int kRed>
void label_bayer(const Lut& lut, const std::uint8_t* upper, const std::uint8_t* lower, Label* out,
                 int quads) {
  for (int x = 0; x < quads; ++x, upper += 2, lower += 2) {
    const std::uint8_t quad[4] = {upper[0], upper[1], lower[0], lower[1]};
    constexpr int kGreen1 = kRed == 0 || kRed == 3 ? 1 : 0, kGreen2 = 3 - kGreen1;
    const auto green = static_cast<std::uint8_t>((quad[kGreen1] + quad[kGreen2] + 1) / 2);
    out[x] = lut.of_rgb(quad[kRed], green, quad[3 - kRed]);
  }
}

void clear_masked_row(const Mask& mask, int y, LabelImage& labels) {
  Label* row = labels.row(y);
  int clear_from = 0;
  for (const Mask::Interval interval : mask.row(y, labels.cell_px)) {
    const int begin = std::min<int>(interval.begin, labels.width);
    std::fill(row + clear_from, row + begin, label::kClear);
    clear_from = std::min<int>(interval.end, labels.width);
  }
  std::fill(row + clear_from, row + labels.width, label::kClear);
}

}  // namespace

void clear_masked(const Mask& mask, LabelImage& labels) {
  for (int y = 0; y < labels.height; ++y) clear_masked_row(mask, y, labels);
}

void Threshold::process(const Params&, const Lut& lut, const Mask& mask, const Image& image,
                        LabelImage& labels) noexcept {
  const ImageView& view = image.view();
  labels.cell_px = is_bayer(view.format) ? 2 : 1;
  labels.width = view.width / labels.cell_px;
  labels.height = view.height / labels.cell_px;
  labels.labels.resize(static_cast<std::size_t>(labels.width) * static_cast<std::size_t>(labels.height));
  for (int y = 0; y < labels.height; ++y) {
    const std::uint8_t* in = view.row(y * labels.cell_px);
    Label* out = labels.row(y);
    switch (view.format) {
      case PixelFormat::kUyvy: label_yuv422<1>(lut, in, out, labels.width); break;
      case PixelFormat::kYuyv: label_yuv422<0>(lut, in, out, labels.width); break;
      case PixelFormat::kRgb24: label_rgb<0>(lut, in, out, labels.width); break;
      case PixelFormat::kBgr24: label_rgb<2>(lut, in, out, labels.width); break;
      case PixelFormat::kMono8: label_mono(lut, in, out, labels.width); break;
      case PixelFormat::kBayerRg8: label_bayer<0>(lut, in, in + view.stride_bytes, out, labels.width); break;
      case PixelFormat::kBayerGr8: label_bayer<1>(lut, in, in + view.stride_bytes, out, labels.width); break;
      case PixelFormat::kBayerGb8: label_bayer<2>(lut, in, in + view.stride_bytes, out, labels.width); break;
      case PixelFormat::kBayerBg8: label_bayer<3>(lut, in, in + view.stride_bytes, out, labels.width); break;
    }
    clear_masked_row(mask, y, labels);
  }
}

}  // namespace sslv
