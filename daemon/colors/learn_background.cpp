// SPDX-License-Identifier: Apache-2.0
#include "colors/learn_background.h"

#include "base/statistics.h"
#include "colors/find_spots.h"
#include "colors/name_dots.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace sslv {
namespace {

constexpr std::size_t kCarpetSamples = 12, kLineSamples = 9;

ColorSample sample_of(Label label, const Color3& color) {
  const auto byte = [](double value) {
    return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
  };
  return {label, {byte(color[0]), byte(color[1]), byte(color[2])}};
}

bool is_at_robot(std::span<const SeenRobot> robots, std::size_t frame, const Eigen::Vector2d& pixel) {
  constexpr double kReachMm = 130;
  return std::any_of(robots.begin(), robots.end(), [&](const SeenRobot& robot) {
    return robot.frame == frame &&
           std::hypot(robot.pixel_x - pixel.x(), robot.pixel_y - pixel.y()) < kReachMm * robot.px_per_mm;
  });
}

/// Selects `count` of the colours, evenly spaced over the logarithm of their brightness.
std::vector<Color3> over_brightness(std::vector<Color3> colors, std::size_t count) {
  std::sort(colors.begin(), colors.end(), [](const Color3& a, const Color3& b) { return a.sum() < b.sum(); });
  std::vector<Color3> out;
  if (colors.empty()) return out;
  const std::size_t n = colors.size(), first = n / 200, last = n - 1 - n / 200;
  const double low = std::max(1.0, colors[first].sum()), high = std::max(low, colors[last].sum());
  for (std::size_t i = 0; i < count; ++i) {
    const double sum = low * std::pow(high / low, static_cast<double>(i) / static_cast<double>(count - 1));
    const auto at = std::lower_bound(colors.begin(), colors.end(), sum,
                                     [](const Color3& color, double value) { return color.sum() < value; });
    // Average some neighbours to reduce noise.
    const auto middle = std::clamp(static_cast<std::size_t>(at - colors.begin()), first, last);
    const std::size_t reach = std::min(n / 100, std::min(middle - first, last - middle));
    Color3 mean = Color3::Zero();
    for (std::size_t j = middle - reach; j <= middle + reach; ++j) mean += colors[j];
    out.push_back(mean / static_cast<double>(2 * reach + 1));
  }
  return out;
}

}  // namespace

std::optional<Color3> carpet_chromaticity(const RobotSearch& search, std::span<const SeenRobot> robots) {
  std::array<std::vector<double>, 3> all;
  std::vector<Color3> colors;
  for (std::size_t frame = 0; frame < search.frames.size(); ++frame) {
    const SmallPicture& picture = search.pictures[frame].finest();
    for (const SeenRobot& robot : robots) {
      if (robot.frame != frame) continue;
      for (int i = 0; i < 24; ++i) {
        const double angle = 2 * std::numbers::pi * i / 24;
        for (const double radius_mm : {125.0, 150.0}) {
          const Eigen::Vector2d pixel(robot.pixel_x + radius_mm * robot.px_per_mm * std::cos(angle),
                                      robot.pixel_y + radius_mm * robot.px_per_mm * std::sin(angle));
          const Eigen::Vector2d cell = picture.cell_of(pixel);
          const int x = static_cast<int>(std::lround(cell.x())), y = static_cast<int>(std::lround(cell.y()));
          if (x < 1 || y < 1 || x + 1 >= picture.width() || y + 1 >= picture.height() || !picture.shows(x, y))
            continue;
          colors.push_back(chromaticity_of(picture.mean(x, y, 1)));
        }
      }
    }
  }
  if (colors.size() < 20) return {};
  Color3 out;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const Color3& color : colors) values.push_back(color[c]);
    out[c] = median(std::move(values));
  }
  const auto alike = std::count_if(colors.begin(), colors.end(),
                                   [&](const Color3& color) { return (color - out).norm() < kCarpetAlike; });
  if (static_cast<double>(alike) < 0.3 * static_cast<double>(colors.size())) return {};
  return out / out.sum();
}

CarpetAndLines carpet_and_lines(const RobotSearch& search, std::span<const SeenRobot> robots,
                                const Color3& chromaticity, const Color3& gains) {
  std::vector<Color3> carpet, lines;
  for (std::size_t frame = 0; frame < search.frames.size() && !search.stop.stop_requested(); ++frame) {
    const SmallPicture& picture = search.pictures[frame].finest();
    const int step = std::max(2, std::min(picture.width(), picture.height()) / 120);
    for (int y = step; y + step < picture.height(); y += step) {
      for (int x = step; x + step < picture.width(); x += step) {
        if (!picture.shows(x, y) || is_at_robot(robots, frame, picture.pixel_of(x, y))) continue;
        const Color3 around = picture.mean(x, y, 1);
        if ((chromaticity_of(around) - chromaticity).norm() < kCarpetAlike) carpet.push_back(around);
      }
    }
    // A line's middle is brighter than the carpet on both its sides, in every channel.
    constexpr int kSide = 12, kNearSide = 5, kEvery = 5;  // two distances, because lines may be wide
    constexpr double kBrighter = 1.35, kBrighterGrey = 10;
    for (int y = kSide + 1; y + kSide + 1 < picture.height(); ++y) {
      for (int x = kSide + 1 + (y * 7) % kEvery; x + kSide + 1 < picture.width(); x += kEvery) {
        if (!picture.shows(x, y)) continue;
        const Color3 here = picture.at(x, y);
        for (const auto& [dx, dy] : {std::pair(kNearSide, 0), {0, kNearSide}, {kSide, 0}, {0, kSide}}) {
          const Color3 one = picture.mean(x - dx, y - dy, 1), other = picture.mean(x + dx, y + dy, 1);
          const Color3 ground = (one + other) / 2;
          if (here.sum() < kBrighter * ground.sum() + kBrighterGrey || (here - ground).minCoeff() <= 0)
            continue;
          if ((chromaticity_of(one) - chromaticity).norm() > kCarpetAlike ||
              (chromaticity_of(other) - chromaticity).norm() > kCarpetAlike)
            continue;
          if (is_at_robot(robots, frame, picture.pixel_of(x, y))) continue;
          lines.push_back(here);
          break;
        }
      }
    }
  }
  CarpetAndLines out;
  for (const Color3& color : over_brightness(carpet, kCarpetSamples))
    out.samples.push_back(sample_of(label::kField, color));

  // The edge of a line is a blend with the carpet. Pixels farthest from the carpet's colour are white.
  const Color3 expected = chromaticity_of(gains);
  out.white_chromaticity = expected;
  const auto towards_white = [&](const Color3& color) {
    return (chromaticity_of(color) - chromaticity).dot(expected - chromaticity) /
           std::max(1e-6, (expected - chromaticity).squaredNorm());
  };
  constexpr double kLikeWhite = 0.12, kTowardsWhite = 0.3;
  std::erase_if(lines, [&](const Color3& color) {
    return towards_white(color) < kTowardsWhite || (chromaticity_of(color) - expected).norm() > kLikeWhite;
  });
  constexpr std::size_t kMinLines = 40;
  if (lines.size() < kMinLines) return out;
  std::sort(lines.begin(), lines.end(),
            [&](const Color3& a, const Color3& b) { return towards_white(a) > towards_white(b); });
  lines.resize(lines.size() / 3);
  for (const Color3& color : over_brightness(lines, kLineSamples))
    out.samples.push_back(sample_of(label::kWhite, color));
  for (int c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const Color3& color : lines) values.push_back(chromaticity_of(color)[c]);
    out.white_chromaticity[c] = median(std::move(values));
  }
  out.white_chromaticity /= out.white_chromaticity.sum();
  return out;
}

}  // namespace sslv
