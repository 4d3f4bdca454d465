// SPDX-License-Identifier: Apache-2.0
#include "vision/field_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace sslv {
namespace {

using Interval = Mask::Interval;

/// Whether a pixel shows the field's ground, or objects on it up to a robot's height.
class SeesField {
 public:
  SeesField(const Scene& scene, double beyond_boundary_mm)
      : camera_(*scene.camera),
        half_length_mm_(scene.field.field_length / 2.0 + scene.field.boundary_width_goal_line +
                        beyond_boundary_mm),
        half_width_mm_(scene.field.field_width / 2.0 + scene.field.boundary_width + beyond_boundary_mm) {
    // The maximum height in the rules, because the teams may not be known yet.
    constexpr double kTallestMm = 150;
    height_mm_ = std::max({kTallestMm, scene.robot_height_mm[0], scene.robot_height_mm[1]});
  }
  bool operator()(const Eigen::Vector2d& pixel) const {
    return at_height(pixel, 0) || at_height(pixel, height_mm_);
  }

 private:
  bool at_height(const Eigen::Vector2d& pixel, double height_mm) const {
    const auto place_mm = camera_.unproject(pixel, height_mm);
    return place_mm && std::abs(place_mm->x()) <= half_length_mm_ &&
           std::abs(place_mm->y()) <= half_width_mm_;
  }
  const CameraModel& camera_;
  double half_length_mm_, half_width_mm_, height_mm_ = 0;
};

}  // namespace

FieldView field_view(const Scene& scene, double beyond_boundary_mm) {
  const CameraCalibration& calibration = scene.camera->calibration();
  const SeesField sees_field(scene, beyond_boundary_mm);
  constexpr int kBandPx = FieldView::kBandPx;
  const auto bands_in = [](int size_px) {
    return static_cast<std::size_t>((size_px + kBandPx - 1) / kBandPx);
  };
  const std::size_t columns = bands_in(calibration.pixel_image_width);
  const auto corners = [&](std::size_t row) {
    std::vector<bool> out(columns + 1);
    for (std::size_t i = 0; i <= columns; ++i)
      out[i] = sees_field({static_cast<double>(i) * kBandPx, static_cast<double>(row) * kBandPx});
    return out;
  };

  FieldView view;
  view.width_px = static_cast<int>(columns) * kBandPx;
  view.bands.resize(bands_in(calibration.pixel_image_height));
  std::vector<bool> above = corners(0);
  for (std::size_t row = 0; row < view.bands.size(); ++row) {
    std::vector<bool> below = corners(row + 1);
    std::vector<Interval>& band = view.bands[row];
    for (std::size_t i = 0; i < columns; ++i) {
      if (!above[i] && !above[i + 1] && !below[i] && !below[i + 1]) continue;
      const auto begin = static_cast<std::uint16_t>(i * kBandPx),
                 end = static_cast<std::uint16_t>(begin + kBandPx);
      if (!band.empty() && band.back().end == begin) {
        band.back().end = end;
      } else {
        band.push_back({begin, end});
      }
    }
    above = std::move(below);
  }
  return view;
}

std::vector<PixelRectangle> hidden_by(const FieldView& view) {
  std::vector<PixelRectangle> out;
  std::vector<std::size_t> above;  // rectangles that end where the band begins
  for (std::size_t row = 0; row < view.bands.size(); ++row) {
    const int top = static_cast<int>(row) * FieldView::kBandPx;
    std::vector<std::size_t> here;
    const auto hide = [&](int left, int right) {
      if (left == right) return;
      const auto same = std::ranges::find_if(
          above, [&](std::size_t i) { return out[i].left_px == left && out[i].width_px == right - left; });
      if (same != above.end()) {
        out[*same].height_px += FieldView::kBandPx;
        here.push_back(*same);
      } else {
        here.push_back(out.size());
        out.push_back({left, top, right - left, FieldView::kBandPx});
      }
    };
    int left = 0;
    for (const Interval& shown : view.bands[row]) {
      hide(left, shown.begin);
      left = shown.end;
    }
    hide(left, view.width_px);
    above = std::move(here);
  }
  return out;
}

}  // namespace sslv
