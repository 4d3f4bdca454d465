// SPDX-License-Identifier: Apache-2.0
#include "calibration/line_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

namespace sslv {
namespace {

/// Adds a row of the frame, as red, green and blue.
void add_yuv_row(const ImageView& frame, int y, std::array<float*, 3> out) {
  const std::uint8_t* bytes = frame.row(y);
  const int luma = frame.format == PixelFormat::kUyvy ? 1 : 0;
  for (int x = 0; x < frame.width; ++x) {
    const std::uint8_t* pair = bytes + 2 * (x & ~1);
    const auto light = static_cast<float>(bytes[2 * x + luma]);
    const float u = static_cast<float>(pair[1 - luma]) - 128, v = static_cast<float>(pair[3 - luma]) - 128;
    out[0][x] += light + 1.402F * v;  // BT.601 full range
    out[1][x] += light - 0.344136F * u - 0.714136F * v;
    out[2][x] += light + 1.772F * u;
  }
}

void add_rgb_row(const ImageView& frame, int y, std::array<float*, 3> out) {
  const std::uint8_t* bytes = frame.row(y);
  const int red = frame.format == PixelFormat::kRgb24 ? 0 : 2;
  for (int x = 0; x < frame.width; ++x) {
    out[0][x] += bytes[3 * x + red];
    out[1][x] += bytes[3 * x + 1];
    out[2][x] += bytes[3 * x + 2 - red];
  }
}

/// Each missing colour is the mean of its nearest samples: two or four samples of the surrounding 3x3.
void add_bayer_row(const ImageView& frame, int y, std::array<float*, 3> out) {
  const int red_x = frame.format == PixelFormat::kBayerGr8 || frame.format == PixelFormat::kBayerBg8 ? 1 : 0;
  const int red_y = frame.format == PixelFormat::kBayerGb8 || frame.format == PixelFormat::kBayerBg8 ? 1 : 0;
  // Mirrors the image at its edges, which keeps the phase of the Bayer pattern.
  const auto inside = [](int at, int size) { return at < 0 ? -at : at >= size ? 2 * size - 2 - at : at; };
  const std::uint8_t* rows[3];
  for (int j = -1; j <= 1; ++j) rows[j + 1] = frame.row(inside(y + j, frame.height));
  for (int x = 0; x < frame.width; ++x) {
    const int left = inside(x - 1, frame.width), right = inside(x + 1, frame.width);
    const auto mean = [](int sum, int count) { return static_cast<float>(sum) / static_cast<float>(count); };
    const float here = rows[1][x];
    const float beside = mean(rows[1][left] + rows[1][right], 2), above = mean(rows[0][x] + rows[2][x], 2);
    const float corners = mean(rows[0][left] + rows[0][right] + rows[2][left] + rows[2][right], 4);
    const float cross = (beside + above) / 2;
    const bool in_red_column = (x & 1) == red_x, in_red_row = (y & 1) == red_y;
    if (in_red_column == in_red_row) {  // a red or blue sample
      out[in_red_row ? 0 : 2][x] += here;
      out[1][x] += cross;
      out[in_red_row ? 2 : 0][x] += corners;
    } else {
      out[in_red_row ? 0 : 2][x] += beside;
      out[1][x] += here;
      out[in_red_row ? 2 : 0][x] += above;
    }
  }
}

FloatPicture blurred(const FloatPicture& in, double sigma_px) {
  const int reach = std::max(1, static_cast<int>(std::ceil(3 * sigma_px)));
  std::vector<float> weight;
  float sum = 0;
  for (int i = -reach; i <= reach; ++i) {
    weight.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma_px * sigma_px))));
    sum += weight.back();
  }
  for (float& one : weight) one /= sum;
  const auto inside = [](int at, int size) { return std::clamp(at, 0, size - 1); };

  FloatPicture rows(in.width, in.height), out(in.width, in.height);
  std::vector<float> padded(static_cast<std::size_t>(in.width + 2 * reach));
  for (int y = 0; y < in.height; ++y) {
    for (int x = -reach; x < in.width + reach; ++x)
      padded[static_cast<std::size_t>(x + reach)] = in.row(y)[inside(x, in.width)];
    float* to = rows.row(y);
    for (std::size_t i = 0; i < weight.size(); ++i) {
      const float* from = padded.data() + i;
      for (int x = 0; x < in.width; ++x) to[x] += weight[i] * from[x];
    }
  }
  for (int y = 0; y < in.height; ++y) {
    float* to = out.row(y);
    for (int i = -reach; i <= reach; ++i) {
      const float* from = rows.row(inside(y + i, in.height));
      const float w = weight[static_cast<std::size_t>(i + reach)];
      for (int x = 0; x < in.width; ++x) to[x] += w * from[x];
    }
  }
  return out;
}

/// Standard deviation of white noise, from the median of second differences; few of them lie on edges
/// (Immerkaer 1996).
float noise_of(const FloatPicture& light) {
  std::vector<float> values;
  for (int y = 1; y + 1 < light.height; y += 5) {
    const float *above = light.row(y - 1), *here = light.row(y), *below = light.row(y + 1);
    for (int x = 1; x + 1 < light.width; x += 5) {
      values.push_back(std::abs(above[x - 1] - 2 * above[x] + above[x + 1] -
                                2 * (here[x - 1] - 2 * here[x] + here[x + 1]) + below[x - 1] - 2 * below[x] +
                                below[x + 1]));
    }
  }
  if (values.empty()) return 1;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  constexpr float kMedianOfNormal = 0.6745F, kGain = 6;  // kGain: root of the mask's sum of squares
  return std::max(0.3F, *middle / (kMedianOfNormal * kGain));
}

/// Raises each value to the pixel's contrast to its two sides, if this contrast is larger.
void raise_to_stand_out(const float* here, const float* one_side, const float* other_side, int count,
                        float* value) {
  for (int i = 0; i < count; ++i) {
    const float a = one_side[i], b = other_side[i];
    const float out = here[i] - std::max(a, b) - 0.5F * std::abs(a - b);
    value[i] = std::max(value[i], out);
  }
}

/// Sets the values of coloured pixels to 0.
void clear_colored(const float* red, const float* green, const float* blue, int count, float noise,
                   float* value) {
  constexpr float kMaxColor = 0.55F;  // maximum for white: range of the channels over the brightest channel
  for (int i = 0; i < count; ++i) {
    const float most = std::max(std::max(red[i], green[i]), blue[i]),
                least = std::min(std::min(red[i], green[i]), blue[i]);
    value[i] = most - least > kMaxColor * most + noise ? 0 : value[i];
  }
}

/// One pass of the squared distance transform, along a row or column: lower envelope of parabolas
/// (Felzenszwalb and Huttenlocher 2012).
void transform_distances(std::span<float> values, std::vector<float>& copy, std::vector<int>& apex,
                         std::vector<float>& begins) {
  const auto count = static_cast<int>(values.size());
  copy.assign(values.begin(), values.end());
  apex.resize(values.size());
  begins.resize(values.size() + 1);
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  const float far = std::numeric_limits<float>::infinity();
  int last = 0;
  apex[0] = 0;
  begins[0] = -far;
  begins[1] = far;
  for (int q = 1; q < count; ++q) {
    float crossing = 0;
    for (;; --last) {
      const int p = apex[at(last)];
      crossing = (copy[at(q)] + static_cast<float>(q * q) - copy[at(p)] - static_cast<float>(p * p)) /
                 static_cast<float>(2 * (q - p));
      if (crossing > begins[at(last)]) break;  // always true for the first, which begins at -infinity
    }
    ++last;
    apex[at(last)] = q;
    begins[at(last)] = crossing;
    begins[at(last + 1)] = far;
  }
  int k = 0;
  for (int q = 0; q < count; ++q) {
    while (begins[at(k + 1)] < static_cast<float>(q)) ++k;
    const int p = apex[at(k)];
    values[at(q)] = static_cast<float>((q - p) * (q - p)) + copy[at(p)];
  }
}

FloatPicture distance_to_lines(const FloatPicture& line, float least) {
  constexpr float kFar = 1e8F;
  FloatPicture out(line.width, line.height);
  for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] = line.values[i] > least ? 0 : kFar;
  std::vector<float> copy, begins;
  std::vector<int> apex;
  for (int y = 0; y < line.height; ++y)
    transform_distances({out.row(y), static_cast<std::size_t>(line.width)}, copy, apex, begins);
  // Several columns at once, because a cache line holds several pixels.
  constexpr int kColumns = 16;
  FloatPicture columns(line.height, kColumns);
  for (int left = 0; left < line.width; left += kColumns) {
    const int count = std::min(kColumns, line.width - left);
    for (int y = 0; y < line.height; ++y) {
      for (int i = 0; i < count; ++i) columns.row(i)[y] = out.row(y)[left + i];
    }
    for (int i = 0; i < count; ++i)
      transform_distances({columns.row(i), static_cast<std::size_t>(line.height)}, copy, apex, begins);
    for (int y = 0; y < line.height; ++y) {
      for (int i = 0; i < count; ++i) out.row(y)[left + i] = std::sqrt(columns.row(i)[y]);
    }
  }
  return out;
}

}  // namespace

bool MeanPicture::add(const ImageView& frame) {
  if (frame.empty() || frame.format == PixelFormat::kMono8) return false;
  if (frames_ == 0) sums_.fill(FloatPicture(frame.width, frame.height));
  if (frame.width != width() || frame.height != height()) return false;
  for (int y = 0; y < frame.height; ++y) {
    const std::array<float*, 3> out{sums_[0].row(y), sums_[1].row(y), sums_[2].row(y)};
    if (is_yuv422(frame.format)) {
      add_yuv_row(frame, y, out);
    } else if (is_bayer(frame.format)) {
      add_bayer_row(frame, y, out);
    } else {
      add_rgb_row(frame, y, out);
    }
  }
  ++frames_;
  return true;
}

FloatPicture MeanPicture::channel(std::size_t i) const {
  FloatPicture out = sums_[i];
  for (float& value : out.values) value /= static_cast<float>(std::max(1, frames_));
  return out;
}

LinePicture find_line_pixels(const MeanPicture& picture, double line_px) {
  const int width = picture.width(), height = picture.height();
  const std::array channels{picture.channel(0), picture.channel(1), picture.channel(2)};
  LinePicture out;
  out.light = FloatPicture(width, height);
  for (std::size_t i = 0; i < out.light.values.size(); ++i)
    out.light.values[i] = (channels[0].values[i] + channels[1].values[i] + channels[2].values[i]) / 3;
  out.noise = noise_of(out.light);

  // Distance of the sides from a line's middle: along the axes, and per axis along the diagonals.
  const int side = std::max(3, static_cast<int>(std::lround(line_px / 2 + 2.5)));
  const int slant = std::max(2, static_cast<int>(std::lround(0.75 * side)));
  const FloatPicture smooth = blurred(out.light, std::max(0.6, 0.3 * line_px));
  out.line = FloatPicture(width, height);
  for (int y = side; y < height - side; ++y) {
    const int count = width - 2 * side;
    const float* here = smooth.row(y) + side;
    float* line = out.line.row(y) + side;
    for (const auto& [dx, dy] : {std::pair{side, 0}, {0, side}, {slant, slant}, {-slant, slant}})
      raise_to_stand_out(here, smooth.row(y + dy) + side + dx, smooth.row(y - dy) + side - dx, count, line);
    clear_colored(channels[0].row(y) + side, channels[1].row(y) + side, channels[2].row(y) + side, count,
                  4 * out.noise, line);
  }
  // Lines cover about one percent of the image.
  std::vector<float> some;
  for (int y = 0; y < height; y += 3) {
    for (int x = 0; x < width; x += 3) some.push_back(out.line.row(y)[x]);
  }
  const auto high = some.begin() + static_cast<std::ptrdiff_t>(0.992 * static_cast<double>(some.size()));
  std::nth_element(some.begin(), high, some.end());
  out.min_line = std::max(4 * out.noise / std::max(1.0F, static_cast<float>(0.6 * line_px)), 0.35F * *high);
  out.distance_px = distance_to_lines(out.line, out.min_line);
  return out;
}

float value_at(const FloatPicture& picture, double x, double y) {
  if (!(x >= 0 && y >= 0 && x < picture.width - 1 && y < picture.height - 1)) return -1;
  const auto left = static_cast<int>(x), top = static_cast<int>(y);
  const float fx = static_cast<float>(x - left), fy = static_cast<float>(y - top);
  const float *above = picture.row(top) + left, *below = above + picture.width;
  return (above[0] * (1 - fx) + above[1] * fx) * (1 - fy) + (below[0] * (1 - fx) + below[1] * fx) * fy;
}

}  // namespace sslv
