// SPDX-License-Identifier: Apache-2.0
#include "camera_bytes.h"

#include "image/jpeg.h"
#include "image/jpeg_decoder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace sslv::halls {
namespace {

/// Normal deviates, drawn from a table of equally likely quantiles.
class Noise {
 public:
  explicit Noise(Chance chance) : chance_(chance) {}
  float next() {
    if (left_ == 0) {
      bits_ = chance_.bits();
      left_ = 5;
    }
    --left_;
    const float out = table()[bits_ & (kSize - 1)];
    bits_ >>= 12;
    return out;
  }

 private:
  static constexpr std::size_t kSize = 4096;
  static const std::array<float, kSize>& table() {
    static const auto kTable = [] {
      std::array<float, kSize> out{};
      // Inverts the normal distribution by bisection.
      for (std::size_t i = 0; i < kSize; ++i) {
        const double share = (static_cast<double>(i) + 0.5) / kSize;
        double low = -6, high = 6;
        for (int step = 0; step < 50; ++step) {
          const double middle = (low + high) / 2;
          (0.5 * std::erfc(-middle / std::sqrt(2.0)) < share ? low : high) = middle;
        }
        out[i] = static_cast<float>(low);
      }
      return out;
    }();
    return kTable;
  }
  Chance chance_;
  std::uint64_t bits_ = 0;
  int left_ = 0;
};

/// Encodes light as 0..255, not rounded, by interpolating in a table.
class Encoder {
 public:
  explicit Encoder(Transfer transfer) : is_linear_(transfer == Transfer::kLinear) {
    for (std::size_t i = 0; i < kSize + 2; ++i) {
      table_[i] = 255 * encoded(static_cast<float>(i) / kSize, transfer);
    }
  }
  float operator()(float light) const {
    const float held = std::clamp(light, 0.0F, 1.0F);
    if (is_linear_) return 255 * held;
    const float place = held * kSize;
    const auto i = static_cast<std::size_t>(place);
    return table_[i] + (table_[i + 1] - table_[i]) * (place - static_cast<float>(i));
  }

 private:
  static constexpr std::size_t kSize = 8192;
  bool is_linear_;
  std::array<float, kSize + 2> table_{};
};

std::uint8_t rounded(float value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
}

/// Compresses to JPEG and back, like cameras and grabbers on a slow link.
void compress(std::vector<std::uint8_t>& bytes, int width, int height, PixelFormat format, int quality) {
  JpegEncoder encoder;
  JpegDecoder decoder;
  std::string problem;
  const ImageView view{bytes.data(), width, height, width * bytes_per_pixel(format), format};
  const auto jpeg = encoder.encode(view, width, quality, Chroma::kFull);
  const ImageView layout = decoder.layout(jpeg, problem);
  if (layout.format != format || layout.width != width || !decoder.decode(jpeg, bytes.data(), problem)) {
    throw std::runtime_error("JPEG and back: " + problem);
  }
}

/// The colour channel of a pixel on a Bayer RG sensor.
constexpr int bayer_channel(int x, int y) {
  return (y & 1) + (x & 1);
}

/// Light with the sensor's noise.
class Photosites {
 public:
  Photosites(const Picture& light, const Sensor& sensor, Chance chance) : light_(light), noise_(chance) {
    // The noise is given in grey levels, but applies to the light.
    const Transfer transfer = sensor.transfer;
    const float grey = decoded(90 / 255.0F, transfer);
    const float slope = (encoded(grey * 1.01F, transfer) - encoded(grey * 0.99F, transfer)) / (grey * 0.02F);
    const auto variance = static_cast<float>(std::pow(sensor.noise_grey / 255 / slope, 2));
    fixed_ = variance * static_cast<float>(1 - sensor.shot_share);
    growing_ = variance * static_cast<float>(sensor.shot_share) / grey;
    if (!sensor.hot_pixels.empty()) hot_.resize(light.pixels.size() * 3);
    for (const HotPixel& pixel : sensor.hot_pixels) {
      hot_[index(pixel.x, pixel.y) * 3 + static_cast<std::size_t>(pixel.channel)] = pixel.light;
    }
  }

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(light_.width) + static_cast<std::size_t>(x);
  }

  /// Adds new noise at each call.
  float light_at(int x, int y, int channel) {
    const std::size_t i = index(x, y);
    float value = light_.pixels[i][channel];
    value += noise_.next() * std::sqrt(fixed_ + growing_ * std::max(0.0F, value));
    if (!hot_.empty()) value += hot_[i * 3 + static_cast<std::size_t>(channel)];
    return value;
  }

  void fill_mosaic() {
    mosaic_.resize(light_.pixels.size());
    for (int y = 0; y < light_.height; ++y) {
      for (int x = 0; x < light_.width; ++x) {
        mosaic_[index(x, y)] = std::clamp(light_at(x, y, bayer_channel(x, y)), 0.0F, 1.0F);
      }
    }
  }
  /// Bilinear demosaicing, as in simple cameras.
  float interpolated(int x, int y, int channel) const {
    if (bayer_channel(x, y) == channel) return mosaic_[index(x, y)];
    float sum = 0;
    int count = 0;
    for (int ny = std::max(0, y - 1); ny <= std::min(light_.height - 1, y + 1); ++ny) {
      for (int nx = std::max(0, x - 1); nx <= std::min(light_.width - 1, x + 1); ++nx) {
        if (bayer_channel(nx, ny) != channel) continue;
        sum += mosaic_[index(nx, ny)];
        ++count;
      }
    }
    return sum / static_cast<float>(count);
  }

 private:
  const Picture& light_;
  Noise noise_;
  float fixed_ = 0, growing_ = 0;
  std::vector<float> hot_, mosaic_;
};

}  // namespace

void blur(Picture& picture, double sigma_px) {
  if (sigma_px <= 0) return;
  const auto reach = static_cast<std::size_t>(std::max(1.0, std::ceil(3 * sigma_px)));
  std::vector<float> weights(2 * reach + 1);
  float sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double away_px = static_cast<double>(i) - static_cast<double>(reach);
    weights[i] = static_cast<float>(std::exp(-0.5 * away_px * away_px / (sigma_px * sigma_px)));
    sum += weights[i];
  }
  for (float& weight : weights) weight /= sum;
  // Rows and columns as flat floats, which compilers vectorise. Edge pixels are repeated beyond the image.
  const std::size_t flat = 3 * static_cast<std::size_t>(picture.width);
  const auto height = static_cast<std::size_t>(picture.height);
  const auto row_at = [&](std::size_t y) { return picture.row(static_cast<int>(y)).front().data(); };
  std::vector<float> padded(flat + 6 * reach);
  for (std::size_t y = 0; y < height; ++y) {
    float* row = row_at(y);
    std::copy(row, row + flat, &padded[3 * reach]);
    for (std::size_t i = 0; i < 3 * reach; ++i) {
      padded[i] = row[i % 3];
      padded[3 * reach + flat + i] = row[flat - 3 + i % 3];
    }
    std::fill(row, row + flat, 0.0F);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      for (std::size_t x = 0; x < flat; ++x) row[x] += weights[i] * padded[x + 3 * i];
    }
  }
  // Columns; `before` keeps the original rows above.
  std::vector<std::vector<float>> before(reach + 1, std::vector<float>(flat));
  std::vector<float> out(flat);
  for (std::size_t y = 0; y < height; ++y) {
    std::copy(row_at(y), row_at(y) + flat, before[y % before.size()].begin());
    std::fill(out.begin(), out.end(), 0.0F);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const std::size_t from = std::min(y + i < reach ? 0 : y + i - reach, height - 1);
      const float* row = from <= y ? before[from % before.size()].data() : row_at(from);
      for (std::size_t x = 0; x < flat; ++x) out[x] += weights[i] * row[x];
    }
    std::copy(out.begin(), out.end(), row_at(y));
  }
}

std::vector<std::uint8_t> camera_bytes(const Picture& light, const Sensor& sensor, PixelFormat format,
                                       Chance chance) {
  const int width = light.width, height = light.height;
  const Encoder encode(sensor.transfer);
  Photosites sites(light, sensor, chance);
  std::vector<std::uint8_t> out(light.pixels.size() * static_cast<std::size_t>(bytes_per_pixel(format)));
  if (format == PixelFormat::kBayerRg8) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        out[sites.index(x, y)] = rounded(encode(sites.light_at(x, y, bayer_channel(x, y))));
      }
    }
    return out;
  }
  if (format != PixelFormat::kRgb24 && format != PixelFormat::kUyvy) {
    throw std::runtime_error("only uyvy, rgb24 and bayer_rg8 are drawn");
  }
  if (sensor.is_mosaic) sites.fill_mosaic();
  const auto code = [&](int x, int y, int channel) {
    return encode(sensor.is_mosaic ? sites.interpolated(x, y, channel) : sites.light_at(x, y, channel));
  };
  std::uint8_t* to = out.data();
  for (int y = 0; y < height; ++y) {
    if (format == PixelFormat::kRgb24) {
      for (int x = 0; x < width; ++x) {
        for (int channel = 0; channel < 3; ++channel) *to++ = rounded(code(x, y, channel));
      }
      continue;
    }
    for (int x = 0; x + 1 < width; x += 2) {
      std::array<float, 2> luma{};
      float u = 128, v = 128;
      for (int k = 0; k < 2; ++k) {
        const float r = code(x + k, y, 0), g = code(x + k, y, 1), b = code(x + k, y, 2);
        const float here = 0.299F * r + 0.587F * g + 0.114F * b;
        luma[static_cast<std::size_t>(k)] = here;
        u += 0.5F * (b - here) / 1.772F;
        v += 0.5F * (r - here) / 1.402F;
      }
      *to++ = rounded(u);
      *to++ = rounded(luma[0]);
      *to++ = rounded(v);
      *to++ = rounded(luma[1]);
    }
  }
  if (sensor.jpeg_quality > 0) compress(out, width, height, format, sensor.jpeg_quality);
  return out;
}

}  // namespace sslv::halls
