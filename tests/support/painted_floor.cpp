// SPDX-License-Identifier: Apache-2.0
#include "support/painted_floor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

namespace sslv {
namespace {

using Color = std::array<float, 3>;
constexpr Color kCarpet{34, 98, 48}, kLine{205, 208, 200}, kFloor{60, 60, 62}, kBlack{28, 28, 31};

struct Wave {
  std::array<double, 3> reach_mm, phase, length_mm;
  double at(double along_mm) const {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += reach_mm[i] * std::sin(along_mm / length_mm[i] + phase[i]);
    return sum;
  }
};

struct Robot {
  double x_mm, y_mm, height_mm;
};

class Floor {
 public:
  Floor(const PaintedFloor& floor, const LensCamera& camera) : floor_(floor), camera_(camera) {
    std::mt19937 random(floor.seed);
    const auto uniform = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    std::normal_distribution<double> normal;
    for (PaintedCurve curve : painted_curves(floor.field, floor.measured)) {
      if (std::find(floor.missing.begin(), floor.missing.end(), curve.name) != floor.missing.end()) continue;
      if (floor.shifted_mm > 0) {
        const auto shift = [&] {
          return Eigen::Vector2d(floor.shifted_mm * normal(random), floor.shifted_mm * normal(random));
        };
        curve.from += shift();
        curve.to = curve.is_arc ? curve.from : Eigen::Vector2d(curve.to + shift());
        if (curve.is_arc) curve.radius_mm += floor.shifted_mm * normal(random);
      }
      curves_.push_back(curve);
      // Amplitudes for a unit rms: half the sum of their squares is one.
      constexpr std::array<double, 3> kShares{1.1, 0.75, 0.48};
      Wave& wave = waves_.emplace_back();
      wave.length_mm = {uniform(1200, 2500), uniform(400, 900), uniform(100, 250)};
      for (std::size_t i = 0; i < 3; ++i) {
        wave.reach_mm[i] = floor.wavy_mm * kShares[i];
        wave.phase[i] = uniform(0, 2 * std::numbers::pi);
      }
    }
    for (int tries = 0; tries < 20000 && static_cast<int>(robots_.size()) < floor.robots; ++tries) {
      Eigen::Vector2d place(uniform(-0.5, 0.5) * floor.field.field_length,
                            uniform(-0.5, 0.5) * floor.field.field_width);
      if (floor.robots_on_lines && robots_.size() % 2 == 0) {
        const PaintedCurve& curve = curves_[random() % curves_.size()];
        place = curve.point(uniform(0, curve.length_mm()));
      }
      const auto pixel = camera.project({place.x(), place.y(), 140});
      const bool free = std::none_of(robots_.begin(), robots_.end(), [&](const Robot& other) {
        return std::hypot(other.x_mm - place.x(), other.y_mm - place.y()) < 190;
      });
      if (pixel && camera.is_in_picture(*pixel, 20) && free) robots_.push_back({place.x(), place.y(), 140});
    }
  }

  /// Indices of the curves and robots that a part of the image may show.
  struct Near {
    std::vector<std::size_t> curves, robots;
    bool whole = true;  // the part shows only one kind of floor
  };
  Near all() const {
    Near out;
    for (std::size_t i = 0; i < curves_.size(); ++i) out.curves.push_back(i);
    for (std::size_t i = 0; i < robots_.size(); ++i) out.robots.push_back(i);
    return out;
  }
  /// The elements of `from` that a square of pixels around (x, y) may show.
  Near near(const Near& from, double x, double y, double half_px) const {
    const auto place = camera_.unproject({x, y}, 0);
    const auto corner = camera_.unproject({x + half_px, y + half_px}, 0);
    if (!place || !corner) return {from.curves, from.robots, false};
    const double reach_mm = 1.5 * (*corner - *place).norm();
    Near out;
    for (const std::size_t i : from.curves) {
      if (outside_mm(*place, i) < reach_mm + 4 * floor_.wavy_mm) out.curves.push_back(i);
    }
    for (const std::size_t i : from.robots) {
      if (std::hypot(place->x() - robots_[i].x_mm, place->y() - robots_[i].y_mm) < 400 + reach_mm)
        out.robots.push_back(i);
    }
    const FieldSize& f = floor_.field;
    out.whole =
        std::abs(std::abs(place->x()) - f.field_length / 2.0 - f.boundary_width_goal_line) > reach_mm &&
        std::abs(std::abs(place->y()) - f.field_width / 2.0 - f.boundary_width) > reach_mm;
    return out;
  }

  /// Distance outside a line's paint, in mm; negative on it.
  double outside_mm(const Eigen::Vector2d& place, std::size_t i) const {
    const PaintedCurve& curve = curves_[i];
    const double half_mm = curve.width_mm / 2;
    double off = 0;
    if (curve.is_arc) {
      const Eigen::Vector2d rel = place - curve.from;
      off = rel.norm() - curve.radius_mm;
      if (std::abs(off) < 60) off -= waves_[i].at(std::atan2(rel.y(), rel.x()) * curve.radius_mm);
      off = std::abs(off);
    } else {
      const Eigen::Vector2d along = curve.direction(0), rel = place - curve.from;
      const double at = rel.dot(along);
      off = along.x() * rel.y() - along.y() * rel.x();
      if (std::abs(off) < 60) off -= waves_[i].at(at);
      const double beyond = std::max({-at, at - curve.length_mm(), 0.0}) - half_mm;
      off = std::abs(off);
      if (beyond > 0) off = std::max(off, beyond + half_mm);
    }
    return off - half_mm;
  }

  bool on_carpet(const Eigen::Vector2d& place) const {
    const FieldSize& f = floor_.field;
    return std::abs(place.x()) < f.field_length / 2.0 + f.boundary_width_goal_line &&
           std::abs(place.y()) < f.field_width / 2.0 + f.boundary_width;
  }

  /// Whether a robot, modelled as a cylinder, hides that place.
  bool hides(const Robot& robot, const Eigen::Vector2d& place) const {
    constexpr double kRadiusMm = 85;
    const Eigen::Vector2d from = place - Eigen::Vector2d(robot.x_mm, robot.y_mm);
    const double up = robot.height_mm / camera_.position_mm.z();
    const Eigen::Vector2d along = up * (camera_.position_mm.head<2>() - place);
    const double t = std::clamp(-from.dot(along) / std::max(1e-9, along.squaredNorm()), 0.0, 1.0);
    return (from + t * along).squaredNorm() < kRadiusMm * kRadiusMm;
  }

  Color color_at(double x, double y, const Near& near) const {
    const auto place = camera_.unproject({x, y}, 0);
    if (!place) return {20, 20, 20};
    const auto hidden = [&](std::size_t i) { return hides(robots_[i], *place); };
    if (std::any_of(near.robots.begin(), near.robots.end(), hidden)) return kBlack;
    const auto painted = [&](std::size_t i) { return outside_mm(*place, i) <= 0; };
    Color color = std::any_of(near.curves.begin(), near.curves.end(), painted) ? kLine
                  : on_carpet(*place)                                          ? kCarpet
                                                                               : kFloor;
    const double across = std::clamp(place->y() / floor_.field.field_width + 0.5, 0.0, 1.0);
    const double light = 1 - (1 - floor_.dim_to) * across;
    for (float& channel : color) channel *= static_cast<float>(light);
    return color;
  }

 private:
  const PaintedFloor& floor_;
  const LensCamera& camera_;
  std::vector<PaintedCurve> curves_;
  std::vector<Wave> waves_;
  std::vector<Robot> robots_;
};

/// A separable Gaussian blur, along rows and then along columns.
void blur(std::vector<Color>& picture, int width, int height, double sigma_px) {
  if (sigma_px <= 0) return;
  const int reach = static_cast<int>(std::ceil(4 * sigma_px));
  std::vector<float> weights;
  float sum = 0;
  for (int i = -reach; i <= reach; ++i) {
    weights.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma_px * sigma_px))));
    sum += weights.back();
  }
  const auto pass = [&](int length, int lines, int step, int line_step) {
    std::vector<Color> copy(static_cast<std::size_t>(length));
    for (int line = 0; line < lines; ++line) {
      Color* const first = picture.data() + std::ptrdiff_t{line} * line_step;
      for (int i = 0; i < length; ++i) copy[static_cast<std::size_t>(i)] = first[std::ptrdiff_t{i} * step];
      for (int i = 0; i < length; ++i) {
        Color out{};
        for (int k = -reach; k <= reach; ++k) {
          const Color& in = copy[static_cast<std::size_t>(std::clamp(i + k, 0, length - 1))];
          for (std::size_t c = 0; c < 3; ++c)
            out[c] += weights[static_cast<std::size_t>(k + reach)] / sum * in[c];
        }
        first[std::ptrdiff_t{i} * step] = out;
      }
    }
  };
  pass(width, height, 1, width);
  pass(height, width, width, 1);
}

}  // namespace

FloorPicture draw_floor(const PaintedFloor& floor, const LensCamera& camera) {
  const Floor painted(floor, camera);
  const int width = camera.width, height = camera.height;
  std::vector<Color> picture(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  constexpr int kBlock = 12;
  const Floor::Near all = painted.all();
  for (int top = 0; top < height; top += kBlock) {
    for (int left = 0; left < width; left += kBlock) {
      const Floor::Near block = painted.near(all, left + kBlock / 2.0, top + kBlock / 2.0, kBlock / 2.0 + 1);
      const bool plain = block.whole && block.curves.empty() && block.robots.empty();
      for (int y = top; y < std::min(height, top + kBlock); ++y) {
        for (int x = left; x < std::min(width, left + kBlock); ++x) {
          const Floor::Near near = plain ? block : painted.near(block, x, y, 1);
          const int samples = near.whole && near.curves.empty() && near.robots.empty() ? 1 : 8;
          Color sum{};
          for (int j = 0; j < samples; ++j) {
            for (int i = 0; i < samples; ++i) {
              const Color one =
                  painted.color_at(x + (i + 0.5) / samples - 0.5, y + (j + 0.5) / samples - 0.5, near);
              for (std::size_t c = 0; c < 3; ++c) sum[c] += one[c];
            }
          }
          for (float& channel : sum) channel /= static_cast<float>(samples * samples);
          picture[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)] = sum;
        }
      }
    }
  }
  blur(picture, width, height, floor.blur_px);
  FloorPicture out;
  out.bytes.reserve(picture.size() * 3);
  std::mt19937 random(floor.seed * 7919 + 13);
  std::normal_distribution<float> noise(0, static_cast<float>(floor.noise_sigma));
  for (const Color& color : picture) {
    for (const float channel : color) {
      const float value = channel + (floor.noise_sigma > 0 ? noise(random) : 0);
      out.bytes.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 255.0F))));
    }
  }
  out.view = {out.bytes.data(), width, height, std::ptrdiff_t{width} * 3, PixelFormat::kRgb24};
  return out;
}

FieldSize floor_field(int size) {
  FieldSize field;  // Division B
  if (size == 0) {
    field.field_length = 6050;
    field.field_width = 4050;
    field.penalty_area_depth = 500;
    field.penalty_area_width = 1200;
    field.goal_width = 700;
  } else if (size == 3) {
    field.field_length = 3025;
    field.field_width = 2025;
    field.penalty_area_depth = 250;
    field.penalty_area_width = 600;
    field.goal_width = 350;
    field.center_circle_radius = 250;
    field.boundary_width = 150;
    field.boundary_width_goal_line = 150;
  } else if (size == 2) {
    field.field_length = 12000;
    field.field_width = 9000;
    field.penalty_area_depth = 1800;
    field.penalty_area_width = 3600;
    field.goal_width = 1800;
  }
  return field;
}

LensCamera floor_camera(const FloorSetting& setting) {
  constexpr std::array kWidth{780, 1280, 2448, 390}, kHeight{580, 1024, 2048, 290};
  constexpr std::array kHeightMm{4000.0, 5000.0, 6000.0, 2000.0};
  const auto size = static_cast<std::size_t>(setting.size);
  const FieldSize field = floor_field(setting.size);
  LensCamera camera;
  camera.width = kWidth[size];
  camera.height = kHeight[size];
  camera.center_x = camera.width / 2.0 + 3.3;
  camera.center_y = camera.height / 2.0 - 2.1;
  camera.k1 = setting.k1;
  camera.k2 = setting.k2;

  const double length = field.field_length / 2.0, width = field.field_width / 2.0,
               edge = field.boundary_width;
  double left = -length - 0.5 * edge, right = length + 0.5 * edge, bottom = -width - 0.5 * edge,
         top = width + 0.5 * edge;
  Eigen::Matrix3d look;  // downwards, the field's length along the image's width
  look << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  if (setting.view == FloorView::kHalf) {
    left = -400, right = length + 0.7 * edge, bottom = -width - 0.7 * edge, top = width + 0.7 * edge;
    look << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  } else if (setting.view == FloorView::kQuarter) {
    left = -350, right = length + 0.7 * edge, bottom = -350, top = width + 0.7 * edge;
  }
  const double deg = std::numbers::pi / 180;
  Eigen::Vector3d turn(setting.tilt_deg * deg, -0.6 * setting.tilt_deg * deg, 0.7 * deg);
  if (setting.tilt_deg > 5) turn.y() = 0.12 * setting.tilt_deg * deg;
  camera.rotation = (Eigen::AngleAxisd(turn.z(), Eigen::Vector3d::UnitZ()) *
                     Eigen::AngleAxisd(turn.y(), Eigen::Vector3d::UnitY()) *
                     Eigen::AngleAxisd(turn.x(), Eigen::Vector3d::UnitX()))
                        .toRotationMatrix() *
                    look;
  const Eigen::Vector3d axis = camera.rotation.row(2);
  const Eigen::Vector3d middle((left + right) / 2, (bottom + top) / 2, 0);
  camera.position_mm = middle - axis * (kHeightMm[size] / -axis.z());
  // The longest focal length with which everything is in view.
  double low = 50, high = 20000;
  for (int i = 0; i < 50; ++i) {
    camera.focal_px = (low + high) / 2;
    bool all = true;
    for (const double x : {left, (left + right) / 2, right}) {
      for (const double y : {bottom, (bottom + top) / 2, top}) {
        const auto pixel = camera.project({x, y, 0});
        all = all && pixel && camera.is_in_picture(*pixel);
      }
    }
    (all ? low : high) = camera.focal_px;
  }
  camera.focal_px = low;
  return camera;
}

double overlap_error_mm(const LensCamera& truth_a, const LensCamera& truth_b, const LensCamera& a,
                        const LensCamera& b, const FieldSize& field, double height_mm) {
  constexpr double kStepMm = 100;
  double squares = 0;
  int count = 0;
  for (double x = -field.field_length / 2.0; x <= field.field_length / 2.0; x += kStepMm) {
    for (double y = -field.field_width / 2.0; y <= field.field_width / 2.0; y += kStepMm) {
      const auto p = truth_a.project({x, y, height_mm}), q = truth_b.project({x, y, height_mm});
      if (!p || !q || !truth_a.is_in_picture(*p) || !truth_b.is_in_picture(*q)) continue;
      const auto by_a = a.unproject(*p, height_mm), by_b = b.unproject(*q, height_mm);
      squares += by_a && by_b ? (*by_a - *by_b).squaredNorm() : 1e12;
      ++count;
    }
  }
  return count > 0 ? std::sqrt(squares / count) : 1e6;
}

double field_error_mm(const LensCamera& truth, const LensCamera& estimate, const FieldSize& field,
                      double height_mm) {
  constexpr double kStepMm = 150;
  double squares = 0;
  int count = 0;
  for (double x = -field.field_length / 2.0; x <= field.field_length / 2.0; x += kStepMm) {
    for (double y = -field.field_width / 2.0; y <= field.field_width / 2.0; y += kStepMm) {
      const auto pixel = truth.project({x, y, height_mm});
      if (!pixel || !truth.is_in_picture(*pixel)) continue;
      const auto place = estimate.unproject(*pixel, height_mm);
      squares += place ? (*place - Eigen::Vector2d(x, y)).squaredNorm() : 1e12;
      ++count;
    }
  }
  return count > 0 ? std::sqrt(squares / count) : 1e6;
}

}  // namespace sslv
