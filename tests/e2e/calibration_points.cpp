// SPDX-License-Identifier: Apache-2.0
#include "e2e/calibration_points.h"

#include <algorithm>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

namespace sslv::test {
namespace {

bool is_in_picture(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  constexpr double kMargin_px = 4;
  return pixel.x() > kMargin_px && pixel.x() < camera.calibration().pixel_image_width - 1 - kMargin_px &&
         pixel.y() > kMargin_px && pixel.y() < camera.calibration().pixel_image_height - 1 - kMargin_px;
}

}  // namespace

Json clicked_points(const CameraModel& camera) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> off_px(-3, 3);
  std::vector<Eigen::Vector2d> seen;
  for (const double side : {-1, 1}) {
    for (const auto& [x, y] : {std::pair{4500.0, 3000.0},
                               {4500.0, -3000.0},
                               {3500.0, 1000.0},
                               {3500.0, -1000.0},
                               {0.0, side * 3000.0}}) {
      const auto pixel = camera.project({side * x, y, 0});
      if (pixel && is_in_picture(camera, *pixel)) seen.push_back(*pixel);
    }
  }
  if (seen.size() != 6)
    throw std::runtime_error("the camera sees " + std::to_string(seen.size()) + " points");
  std::shuffle(seen.begin(), seen.end(), random);
  Json points = Json::array();
  for (const Eigen::Vector2d& pixel : seen) {
    const double x = pixel.x() + off_px(random), y = pixel.y() + off_px(random);
    points.push_back({{"x", x}, {"y", y}});
  }
  return points;
}

double worst_error_mm(const CameraModel& camera, const CameraModel& other, double height_mm) {
  double worst = 0;
  for (int x = -4500; x <= 4500; x += 250) {
    for (int y = -3000; y <= 3000; y += 250) {
      const auto pixel = camera.project({static_cast<double>(x), static_cast<double>(y), height_mm});
      if (!pixel || !is_in_picture(camera, *pixel)) continue;
      const auto place = other.unproject(*pixel, height_mm);
      if (!place) return std::numeric_limits<double>::infinity();
      worst = std::max(worst, (*place - Eigen::Vector2d(x, y)).norm());
    }
  }
  return worst;
}

}  // namespace sslv::test
