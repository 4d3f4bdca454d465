// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

namespace sslv {
namespace {

constexpr std::size_t kNoiseEntries = 1U << 16;
constexpr std::size_t kBlockPx = 8;       // side of a JPEG block
constexpr std::size_t kBlockPairs = 512;  // number of precomputed pairs of blocks

std::uint8_t added(std::uint8_t sample, std::int8_t noise) {
  const auto sum = static_cast<std::int16_t>(sample + noise);
  return static_cast<std::uint8_t>(std::max<std::int16_t>(0, std::min<std::int16_t>(sum, 255)));
}

void add_saturated(const std::uint8_t* __restrict in, const std::int8_t* __restrict noise,
                   std::uint8_t* __restrict out, std::size_t count) {
  constexpr std::size_t kBlock = 32;  // constant, so that compilers use vector instructions
  for (; count >= kBlock; count -= kBlock, in += kBlock, noise += kBlock, out += kBlock) {
    for (std::size_t i = 0; i < kBlock; ++i) out[i] = added(in[i], noise[i]);
  }
  for (std::size_t i = 0; i < count; ++i) out[i] = added(in[i], noise[i]);
}

std::uint8_t byte(float value) {
  const float up = std::clamp(value, 0.0F, 255.0F) + 0.5F;
  return static_cast<std::uint8_t>(up);
}

/// BT.601 full range, like image/color.h but without rounding.
struct FloatYuv {
  float y, u, v;
  explicit FloatYuv(const float* rgb)
      : y(0.299F * rgb[0] + 0.587F * rgb[1] + 0.114F * rgb[2]),
        u(0.564334F * (rgb[2] - y) + 128),
        v(0.713267F * (rgb[0] - y) + 128) {}
};

/// Offsets of the samples of two pixels in a YUV image's unit of 4 bytes; the pixels share U and V.
struct YuvUnit {
  std::size_t y0, u, y1, v;
};
constexpr YuvUnit yuv_unit(PixelFormat format) {
  return format == PixelFormat::kUyvy ? YuvUnit{1, 0, 3, 2} : YuvUnit{0, 1, 2, 3};
}

bool is_yuv(PixelFormat format) {
  return format == PixelFormat::kUyvy || format == PixelFormat::kYuyv;
}

/// Channel (0 red, 1 green, 2 blue) of each pixel of a 2x2 quad, row by row.
std::array<int, 4> bayer_channels(PixelFormat format) {
  switch (format) {
    case PixelFormat::kBayerGr8: return {1, 0, 2, 1};
    case PixelFormat::kBayerGb8: return {1, 2, 0, 1};
    case PixelFormat::kBayerBg8: return {2, 1, 1, 0};
    default: return {0, 1, 1, 2};
  }
}

}  // namespace

SimulatorSensor::SimulatorSensor(const SimulatorOptions& options, std::uint64_t stream)
    : options_(options),
      row_gains_(static_cast<std::size_t>(options.height), 1),
      noise_unit_(is_yuv(options.pixel_format) ? 4 : 1),
      random_(scatter(stream)) {
  options_.hall = resolved(options.hall);
  const double sigma = options.blur_sigma_px;
  double sum = 0;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  for (int i = 0; i <= radius; ++i) {
    kernel_.push_back(static_cast<float>(i == 0 ? 1 : std::exp(-0.5 * i * i / (sigma * sigma))));
    sum += (i == 0 ? 1 : 2) * kernel_.back();
  }
  for (float& weight : kernel_) weight /= static_cast<float>(sum);

  if (options.noise_sigma > 0) {
    const auto row_samples = plane_bytes() / static_cast<std::size_t>(options.height);
    fill_noise(kNoiseEntries + row_samples);
  }
  if (options_.hall.sensor.block_noise.value() > 0) fill_block_noise();
  place_hot_pixels(stream);
}

void SimulatorSensor::fill_noise(std::size_t entries) {
  if (is_deep()) {
    deep_noise_.resize(entries);
    for (std::int16_t& e : deep_noise_) {
      const double noise = 256 * options_.noise_sigma * random_.normal();
      e = static_cast<std::int16_t>(std::clamp<long>(std::lround(noise), -32767, 32767));
    }
    return;
  }
  noise_.resize(entries);
  const auto entry = [](double noise) {
    return static_cast<std::int8_t>(std::clamp<long>(std::lround(noise), -127, 127));
  };
  if (noise_unit_ == 1) {
    for (std::int8_t& e : noise_) e = entry(options_.noise_sigma * random_.normal());
    return;
  }
  const YuvUnit unit = yuv_unit(options_.pixel_format);
  for (std::size_t i = 0; i + noise_unit_ <= entries; i += noise_unit_) {
    std::array<float, 6> rgb;
    for (float& channel : rgb) channel = static_cast<float>(options_.noise_sigma * random_.normal());
    const FloatYuv left(rgb.data()), right(rgb.data() + 3);
    noise_[i + unit.y0] = entry(left.y);
    noise_[i + unit.y1] = entry(right.y);
    noise_[i + unit.u] = entry(0.5 * (left.u + right.u) - 128);
    noise_[i + unit.v] = entry(0.5 * (left.v + right.v) - 128);
  }
}

std::size_t SimulatorSensor::plane_bytes() const {
  return static_cast<std::size_t>(options_.width) * static_cast<std::size_t>(options_.height) *
         static_cast<std::size_t>(bytes_per_pixel(options_.pixel_format));
}

DrawnBox SimulatorSensor::reached_from(const DrawnBox& box) const {
  const int blur = static_cast<int>(kernel_.size()) - 1;
  const int left = std::max(0, box.left - blur), right = std::min(options_.width, box.right + blur);
  return {left & ~1, std::max(0, box.top - blur), std::min(options_.width, (right + 1) & ~1),
          std::min(options_.height, box.bottom + blur)};
}

/// Blurs row y of the box's columns horizontally; repeats the outermost pixel at the rim.
void SimulatorSensor::blur_row(const LightPicture& light, const DrawnBox& box, int y, float* out) const {
  const int radius = static_cast<int>(kernel_.size()) - 1;
  const int row = std::clamp(y, 0, light.height - 1);
  constexpr float kGrey = 1.0F / LightPicture::kPerGrey;
  for (int x = box.left; x < box.right; ++x, out += 3) {
    const std::uint16_t* middle = light.at(x, row);
    for (int c = 0; c < 3; ++c) out[c] = kernel_[0] * kGrey * middle[c];
    for (int i = 1; i <= radius; ++i) {
      const std::uint16_t* before = light.at(std::max(0, x - i), row);
      const std::uint16_t* after = light.at(std::min(light.width - 1, x + i), row);
      const float weight = kernel_[static_cast<std::size_t>(i)] * kGrey;
      for (int c = 0; c < 3; ++c) out[c] += weight * static_cast<float>(before[c] + after[c]);
    }
  }
}

void SimulatorSensor::write_row(const float* rgb, const DrawnBox& box, int y, std::uint8_t* picture) const {
  const int pixel_bytes = bytes_per_pixel(options_.pixel_format);
  std::uint8_t* out = picture + (static_cast<std::size_t>(y) * static_cast<std::size_t>(options_.width) +
                                 static_cast<std::size_t>(box.left)) *
                                    static_cast<std::size_t>(pixel_bytes);
  const int width = box.right - box.left;
  std::uint8_t* const low = is_deep() ? out + plane_bytes() : nullptr;
  const auto put = [&](int x, float value) {
    if (low == nullptr) {
      out[x] = byte(value);
    } else {  // truncated, not rounded, as in cameras
      const auto deep = static_cast<int>(256 * std::clamp(value, 0.0F, 255.0F));
      out[x] = static_cast<std::uint8_t>(deep >> 8);
      low[x] = static_cast<std::uint8_t>(deep);
    }
  };
  switch (options_.pixel_format) {
    case PixelFormat::kUyvy:
    case PixelFormat::kYuyv: {
      const YuvUnit unit = yuv_unit(options_.pixel_format);
      for (int x = 0; x < width; x += 2, rgb += 6, out += 4) {
        const FloatYuv left(rgb), right(rgb + 3);
        out[unit.y0] = byte(left.y);
        out[unit.y1] = byte(right.y);
        out[unit.u] = byte(0.5F * (left.u + right.u));
        out[unit.v] = byte(0.5F * (left.v + right.v));
      }
      return;
    }
    case PixelFormat::kRgb24:
      for (int i = 0; i < 3 * width; ++i) out[i] = byte(rgb[i]);
      return;
    case PixelFormat::kBgr24:
      for (int x = 0; x < width; ++x, rgb += 3, out += 3) {
        for (int c = 0; c < 3; ++c) out[c] = byte(rgb[2 - c]);
      }
      return;
    case PixelFormat::kMono8:
      for (int x = 0; x < width; ++x, rgb += 3) put(x, FloatYuv(rgb).y);
      return;
    case PixelFormat::kBayerRg8:
    case PixelFormat::kBayerGr8:
    case PixelFormat::kBayerGb8:
    case PixelFormat::kBayerBg8: {
      const auto channels = bayer_channels(options_.pixel_format);
      const int even = channels[y % 2 == 0 ? 0 : 2], odd = channels[y % 2 == 0 ? 1 : 3];
      for (int x = 0; x < width; ++x, rgb += 3) put(x, rgb[x % 2 == 0 ? even : odd]);  // box.left is even
      return;
    }
  }
}

/// Calls `use` with each row of the box after the lens blur.
template <class Use>
void SimulatorSensor::blur(const LightPicture& light, const DrawnBox& box, const Use& use) {
  const int radius = static_cast<int>(kernel_.size()) - 1;
  const int rows = box.bottom - box.top + 2 * radius;
  const auto row_floats = 3 * static_cast<std::size_t>(box.right - box.left);
  rows_.resize(std::max(rows_.size(), row_floats * static_cast<std::size_t>(rows)));
  line_.resize(std::max(line_.size(), row_floats));
  const auto row_at = [&](int y) {
    return rows_.data() + row_floats * static_cast<std::size_t>(y - box.top + radius);
  };

  for (int y = box.top - radius; y < box.bottom + radius; ++y) blur_row(light, box, y, row_at(y));
  for (int y = box.top; y < box.bottom; ++y) {
    const float* middle = row_at(y);
    for (std::size_t i = 0; i < row_floats; ++i) line_[i] = kernel_[0] * middle[i];
    for (int k = 1; k <= radius; ++k) {
      const float *above = row_at(y - k), *below = row_at(y + k);
      const float weight = kernel_[static_cast<std::size_t>(k)];
      for (std::size_t i = 0; i < row_floats; ++i) line_[i] += weight * (above[i] + below[i]);
    }
    use(y, line_.data());
  }
}

/// Converts a row of light to bytes; modifies `rgb`.
void SimulatorSensor::expose_row(float* rgb, const DrawnBox& box, int y, std::uint8_t* picture) const {
  // Pixels saturate at 255, before any mixing of colours.
  std::array<float, 3> gains = gains_;
  for (float& gain : gains) gain *= row_gains_[static_cast<std::size_t>(y)];
  const auto row_floats = 3 * static_cast<std::size_t>(box.right - box.left);
  for (std::size_t i = 0; i < row_floats; i += 3) {
    for (std::size_t c = 0; c < 3; ++c) rgb[i + c] = std::min(gains[c] * rgb[i + c], 255.0F);
  }
  write_row(rgb, box, y, picture);
}

void SimulatorSensor::develop(const LightPicture& light, const DrawnBox& box, std::uint8_t* picture) {
  blur(light, box, [&](int y, float* rgb) { expose_row(rgb, box, y, picture); });
}

std::vector<float> SimulatorSensor::blurred(const LightPicture& light) {
  std::vector<float> out(light.rgb.size());
  float* to = out.data();
  const auto row_floats = 3 * static_cast<std::size_t>(light.width);
  constexpr int kBandRows = 64;  // limits the memory for rows_
  for (int top = 0; top < light.height; top += kBandRows) {
    const DrawnBox band{0, top, light.width, std::min(light.height, top + kBandRows)};
    blur(light, band, [&](int /*y*/, const float* rgb) { to = std::copy_n(rgb, row_floats, to); });
  }
  return out;
}

void SimulatorSensor::develop_blurred(const std::vector<float>& blurred, std::uint8_t* picture) {
  const DrawnBox whole{0, 0, options_.width, options_.height};
  const auto row_floats = 3 * static_cast<std::size_t>(options_.width);
  line_.resize(std::max(line_.size(), row_floats));
  for (int y = 0; y < options_.height; ++y) {
    std::copy_n(blurred.data() + row_floats * static_cast<std::size_t>(y), row_floats, line_.data());
    expose_row(line_.data(), whole, y, picture);
  }
}

void SimulatorSensor::add_noise(const std::uint8_t* clean, std::uint8_t* noisy) {
  if (is_deep()) {
    add_deep_noise(clean, noisy);
  } else if (noise_.empty()) {
    std::memcpy(noisy, clean, picture_bytes());
  } else {
    const auto row_samples = plane_bytes() / static_cast<std::size_t>(options_.height);
    for (int y = 0; y < options_.height; ++y) {
      const std::size_t from = random_.bits() % (kNoiseEntries / noise_unit_) * noise_unit_;
      const std::size_t at = static_cast<std::size_t>(y) * row_samples;
      add_saturated(clean + at, noise_.data() + from, noisy + at, row_samples);
    }
  }
  if (!block_noise_.empty()) add_block_noise(noisy);
  for (const HotSample& hot : hot_samples_) {
    noisy[hot.at] = static_cast<std::uint8_t>(std::clamp(noisy[hot.at] + hot.excess, 0, 255));
  }
}

/// Also truncates each noisy sample to the camera's bit depth.
void SimulatorSensor::add_deep_noise(const std::uint8_t* clean, std::uint8_t* noisy) {
  const std::size_t plane = plane_bytes();
  const auto row_samples = static_cast<std::size_t>(options_.width);
  const int kept = ~((1 << (16 - options_.bits)) - 1);
  for (std::size_t row = 0; row < plane; row += row_samples) {
    const std::int16_t* noise =
        deep_noise_.empty() ? nullptr : deep_noise_.data() + random_.bits() % kNoiseEntries;
    for (std::size_t i = 0; i < row_samples; ++i) {
      const std::size_t at = row + i;
      const int value = (clean[at] << 8 | clean[plane + at]) + (noise != nullptr ? noise[i] : 0);
      const int sample = std::clamp(value, 0, 0xFF00) & kept;
      noisy[at] = static_cast<std::uint8_t>(sample >> 8);
      noisy[plane + at] = static_cast<std::uint8_t>(sample);
    }
  }
}

/// Precomputes errors in the lowest frequencies of blocks, like those of JPEG quantisation. The two blocks of
/// a pair share a colour error.
void SimulatorSensor::fill_block_noise() {
  constexpr std::size_t kPairPx = 2 * kBlockPx;
  const auto pixel_bytes = static_cast<std::size_t>(bytes_per_pixel(options_.pixel_format));
  const auto entries =
      (kBlockPairs * kPairPx + static_cast<std::size_t>(options_.width) + kPairPx) * pixel_bytes;
  block_noise_.resize(kBlockPx * entries);
  const auto sigma = options_.hall.sensor.block_noise.value();
  struct Wave {
    std::array<double, 4> weights;
    double at(double x, double y) const {
      const double along = std::numbers::sqrt2 * std::cos(std::numbers::pi * x);
      const double down = std::numbers::sqrt2 * std::cos(std::numbers::pi * y);
      return weights[0] + weights[1] * along + weights[2] * down + weights[3] * along * down;
    }
  };
  const auto wave = [&](double of) {
    Wave out{};
    for (double& weight : out.weights) weight = of / 2 * random_.normal();
    return out;
  };
  for (std::size_t pair = 0; (pair + 1) * kPairPx * pixel_bytes <= entries; ++pair) {
    const std::array bright{wave(sigma), wave(sigma)};
    const Wave red = wave(sigma), blue = wave(sigma);  // V and U
    for (std::size_t y = 0; y < kBlockPx; ++y) {
      const double down = (static_cast<double>(y) + 0.5) / kBlockPx;
      for (std::size_t x = 0; x < kPairPx; ++x) {
        const double luma =
            bright[x / kBlockPx].at((static_cast<double>(x % kBlockPx) + 0.5) / kBlockPx, down);
        const double across = (static_cast<double>(x) + 0.5) / kPairPx;
        const double u = blue.at(across, down), v = red.at(across, down);
        const std::array rgb{luma + 1.402 * v, luma - 0.344 * u - 0.714 * v, luma + 1.772 * u};
        std::int8_t* out = block_noise_.data() + y * entries + (pair * kPairPx + x) * pixel_bytes;
        const auto entry = [](double noise) {
          return static_cast<std::int8_t>(std::clamp<long>(std::lround(noise), -127, 127));
        };
        if (is_yuv(options_.pixel_format)) {
          const YuvUnit unit = yuv_unit(options_.pixel_format);
          out[x % 2 == 0 ? unit.y0 : unit.y1 - 2] = entry(luma);
          out[x % 2 == 0 ? unit.u : unit.v - 2] = entry(x % 2 == 0 ? u : v);
        } else if (pixel_bytes == 3) {
          for (std::size_t c = 0; c < 3; ++c)
            out[c] = entry(rgb[options_.pixel_format == PixelFormat::kRgb24 ? c : 2 - c]);
        } else {
          *out = entry(luma);
        }
      }
    }
  }
}

void SimulatorSensor::add_block_noise(std::uint8_t* picture) {
  const auto row_samples = plane_bytes() / static_cast<std::size_t>(options_.height);
  const std::size_t entries = block_noise_.size() / kBlockPx;
  const auto pair_samples = 2 * kBlockPx * static_cast<std::size_t>(bytes_per_pixel(options_.pixel_format));
  std::size_t from = 0;
  for (int y = 0; y < options_.height; ++y, picture += row_samples) {
    const std::size_t in_block = static_cast<std::size_t>(y) % kBlockPx;
    if (in_block == 0) from = random_.bits() % kBlockPairs * pair_samples;
    const std::int8_t* noise = block_noise_.data() + in_block * entries + from;
    for (std::size_t i = 0; i < row_samples; ++i) picture[i] = added(picture[i], noise[i]);
  }
}

void SimulatorSensor::place_hot_pixels(std::uint64_t stream) {
  const double pixels = static_cast<double>(options_.width) * options_.height;
  const auto count = std::llround(options_.hall.sensor.hot_pixels.value() * pixels * 1e-6);
  const std::uint64_t camera = stream & 0xffffffffU;
  SimulatorRandom random(scatter(scatter(static_cast<std::uint64_t>(options_.hall.seed)) + camera) + 7);
  for (long long i = 0; i < count; ++i) {
    const auto x = static_cast<std::size_t>(random.bits() % static_cast<std::uint64_t>(options_.width));
    const auto y = static_cast<std::size_t>(random.bits() % static_cast<std::uint64_t>(options_.height));
    // Only a few hot pixels are much too bright.
    const double excess = 40 * std::exp(random.uniform(0, 1.6));
    const auto color = static_cast<std::size_t>(random.bits() % 3);
    const std::size_t pixel = y * static_cast<std::size_t>(options_.width) + x;
    const auto add = [&](std::size_t at, double value) {
      hot_samples_.push_back({at, static_cast<int>(std::lround(value))});
    };
    if (is_yuv(options_.pixel_format)) {
      std::array<float, 3> rgb{0, 0, 0};
      rgb[color] = static_cast<float>(excess);
      const FloatYuv yuv(rgb.data());
      const YuvUnit unit = yuv_unit(options_.pixel_format);
      const std::size_t at = pixel / 2 * 4;
      add(at + (pixel % 2 == 0 ? unit.y0 : unit.y1), yuv.y);
      add(at + unit.u, (yuv.u - 128) / 2);
      add(at + unit.v, (yuv.v - 128) / 2);
    } else {
      const auto pixel_bytes = static_cast<std::size_t>(bytes_per_pixel(options_.pixel_format));
      add(pixel * pixel_bytes + (pixel_bytes == 3 ? color : 0), excess);
    }
  }
}

}  // namespace sslv
