// SPDX-License-Identifier: Apache-2.0
#include "hall.h"

#include "colors/learn_colors.h"
#include "config/backends.h"
#include "config/config.h"
#include "image/color.h"
#include "support/paths.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <vector>

namespace sslv::bench {
namespace {

using Color = std::array<double, 3>;                                // red, green, blue
constexpr Color kDrawnCarpet{30, 92, 62}, kDrawnFloor{92, 88, 84};  // the simulator's
constexpr Color kCarpet{34, 98, 48}, kFloor{60, 60, 62};
constexpr int kMinWidth = 780;  // image width for which lengths are given, px

Config demo() {
  std::ifstream in(source_path("/config/demo.json"));
  return read_config(Json::parse(in));
}

/// Similarity of two colours' chromaticities: 1 when equal, 0 from distance `reach` on.
double likeness(const Color& c, const Color& to, double reach) {
  const double sum = c[0] + c[1] + c[2], to_sum = to[0] + to[1] + to[2];
  if (sum < 1) return 0;
  double distance = 0;
  for (std::size_t k = 0; k < 3; ++k) distance += std::abs(c[k] / sum - to[k] / to_sum);
  return std::clamp(1 - distance / reach, 0.0, 1.0);
}

/// Random values on a grid, interpolated smoothly, with a standard deviation of about 1.
class Blotches {
 public:
  Blotches(int width, int height, double cell_px, std::mt19937& random)
      : cell_px_(cell_px), columns_(static_cast<int>(width / cell_px) + 3) {
    const int rows = static_cast<int>(height / cell_px) + 3;
    std::normal_distribution<float> normal;
    for (int i = 0; i < columns_ * rows; ++i) values_.push_back(normal(random));
  }
  double at(int x, int y) const {
    const double gx = x / cell_px_, gy = y / cell_px_;
    const int ix = static_cast<int>(gx), iy = static_cast<int>(gy);
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double tx = smooth(gx - ix), ty = smooth(gy - iy);
    const auto value = [&](int i, int j) {
      return static_cast<double>(values_[static_cast<std::size_t>((iy + j) * columns_ + ix + i)]);
    };
    // Interpolation averages neighbours, which reduces the variance: compensate.
    return 1.35 * ((value(0, 0) * (1 - tx) + value(1, 0) * tx) * (1 - ty) +
                   (value(0, 1) * (1 - tx) + value(1, 1) * tx) * ty);
  }

 private:
  double cell_px_;
  int columns_;
  std::vector<float> values_;
};

std::uint8_t byte(double value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

}  // namespace

Recording draw_hall(const HallKind& hall, PixelFormat format, int width, int height, int frames) {
  const Recording clean = draw_frames(demo(), 0, PixelFormat::kRgb24, width, height, frames,
                                      {{"noise_sigma", 0}, {"gradient", 0}, {"vignette", 0}});
  std::mt19937 random(5);
  const double scale = static_cast<double>(width) / kMinWidth;
  const Blotches large(width, height, 60 * scale, random), small(width, height, 14 * scale, random);
  const Blotches of_floor(width, height, 30 * scale, random);
  std::normal_distribution<double> normal(0, hall.noise_sigma);
  std::vector<float> noise(1 << 20);
  for (float& value : noise) value = static_cast<float>(normal(random));

  Recording out;
  std::vector<Color> row(static_cast<std::size_t>(width));
  for (std::size_t frame = 0; frame < clean.views.size(); ++frame) {
    const ImageView& from = clean.views[frame];
    auto& bytes =
        out.buffers.emplace_back(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                                 static_cast<std::size_t>(bytes_per_pixel(format)));
    const ImageView to{bytes.data(), width, height, width * bytes_per_pixel(format), format};
    out.views.push_back(to);
    for (int y = 0; y < height; ++y) {
      std::size_t at = random() % noise.size();
      for (int x = 0; x < width; ++x) {
        const std::uint8_t* pixel = from.row(y) + 3 * x;
        Color c{pixel[0] * 1.0, pixel[1] * 1.0, pixel[2] * 1.0};
        const double carpet = likeness(c, kDrawnCarpet, 0.3),
                     floor = likeness(c, kDrawnFloor, 0.06) * (c[1] < 130 && c[1] > 50 ? 1 : 0);
        const double texture = 1 +
                               carpet * hall.carpet_texture * (0.8 * large.at(x, y) + 0.6 * small.at(x, y)) +
                               floor * hall.floor_texture * of_floor.at(x, y);
        const double dx = (x - width * 0.5) / width, dy = (y - height * 0.5) / height;
        const double lamps = 1 + hall.lamps * std::cos(7 * dx + 1) * std::cos(5 * dy - 0.5);
        const double vignette = 1 - hall.vignette * 2 * (dx * dx + dy * dy);
        const double gain = hall.light[frame % hall.light.size()] * texture * lamps * vignette;
        for (std::size_t k = 0; k < 3; ++k) {
          const double paint =
              1 + carpet * (kCarpet[k] / kDrawnCarpet[k] - 1) + floor * (kFloor[k] / kDrawnFloor[k] - 1);
          at = (at + 1) % noise.size();
          c[k] = c[k] * paint * gain + static_cast<double>(noise[at]);
        }
        row[static_cast<std::size_t>(x)] = c;
      }
      std::uint8_t* line = bytes.data() + y * to.stride_bytes;
      for (int x = 0; x < width; ++x) {
        const Color& c = row[static_cast<std::size_t>(x)];
        const double luma = 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2];
        if (format == PixelFormat::kUyvy) {
          line[2 * x + 1] = byte(luma);
          line[2 * x] = byte(128 + (x % 2 == 0 ? 0.564 * (c[2] - luma)
                                               : 0.713 * (row[static_cast<std::size_t>(x - 1)][0] - luma)));
          if (x % 2 == 1) {
            const Color& first = row[static_cast<std::size_t>(x - 1)];
            const double first_luma = 0.299 * first[0] + 0.587 * first[1] + 0.114 * first[2];
            line[2 * x] = byte(128 + 0.713 * (first[0] - first_luma));
          }
        } else if (format == PixelFormat::kRgb24) {
          for (int k = 0; k < 3; ++k) line[3 * x + k] = byte(c[static_cast<std::size_t>(k)]);
        } else {  // Bayer RG
          line[x] = byte(c[static_cast<std::size_t>(y % 2 + x % 2)]);
        }
      }
    }
  }
  return out;
}

std::shared_ptr<const Lut> lut_with_margins(const HallKind& hall) {
  ColorTable table = make_color_table(demo().cameras[0].colors, "");
  constexpr double kMargin = 1.5;
  const double brightest = kMargin * (1 + hall.lamps) * (1 + hall.carpet_texture) *
                           *std::max_element(hall.light.begin(), hall.light.end());
  const Label green = *LabelSet::built_in().find("green");
  for (std::size_t cell = 0; cell < table.labels.size(); ++cell) {
    const Yuv yuv = table.color_of(cell);
    const double u = yuv.u - 128.0, v = yuv.v - 128.0;
    const Color c{yuv.y + 1.402 * v, yuv.y - 0.34414 * u - 0.71414 * v, yuv.y + 1.772 * u};
    const auto in_cone = [&](const Color& axis, double& gain) {
      double dot = 0, length2 = 0, square = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        dot += c[k] * axis[k];
        length2 += axis[k] * axis[k];
      }
      gain = dot / length2;
      for (std::size_t k = 0; k < 3; ++k) square += std::pow(c[k] - gain * axis[k], 2);
      return std::sqrt(square) < 20 + 0.15 * gain * std::sqrt(length2);
    };
    Label& label = table.labels[cell];
    double gain = 0;
    if (in_cone(kCarpet, gain)) label = gain < brightest ? label::kClear : green;
    if (in_cone(kFloor, gain)) label = label::kClear;
    if (yuv.y < 40) label = label::kClear;
  }
  return std::make_shared<const Lut>(std::move(table));
}

std::shared_ptr<const Lut> learnt_lut(const Recording& recording, int width, int height) {
  const Config config = demo();
  const CameraContext context = make_context(config, 0, std::make_shared<const Lut>());
  Scene scene = *context.scene;
  CameraCalibration calibration = *config.cameras[0].calibration;
  const double scale = std::min(static_cast<double>(width) / calibration.pixel_image_width,
                                static_cast<double>(height) / calibration.pixel_image_height);
  calibration.focal_length *= scale;
  calibration.principal_point_x = (calibration.principal_point_x + 0.5) * scale - 0.5;
  calibration.principal_point_y = (calibration.principal_point_y + 0.5) * scale - 0.5;
  calibration.pixel_image_width = width;
  calibration.pixel_image_height = height;
  scene.camera.emplace(calibration, "");
  return learn_colors({{recording.views.front()}, scene, *context.patterns}).lut;
}

}  // namespace sslv::bench
