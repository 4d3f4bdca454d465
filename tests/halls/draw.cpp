// SPDX-License-Identifier: Apache-2.0
#include "draw.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sslv::halls {
namespace {

// Rays per side of a pixel; 8: the centre of a 9 px dot has an rms error of 0.006 px.
constexpr int kRaysOfPlay = 8;
constexpr int kRaysOfFurniture = 4;
// Number of moments of the exposure at which moving things are drawn: at 4 m/s and 8 ms, 4 mm apart.
constexpr int kMoments = 8;

Eigen::AlignedBox2d lit_area(const Hall& hall) {
  const Eigen::Vector2d corner(hall.field.field_length / 2.0, hall.field.field_width / 2.0);
  return {-corner, corner};
}

}  // namespace

Painter::Painter(const Hall& hall, const CameraModel& camera)
    : hall_(hall),
      camera_(camera),
      light_(hall.lighting, camera, lit_area(hall)),
      still_(hall.calibration.pixel_image_width, hall.calibration.pixel_image_height),
      obstacles_(still_.pixels.size()) {
  draw_floor();
  std::vector<const Solid*> solids;
  for (const auto& solid : hall.furniture) solids.push_back(solid.get());
  draw_solids(solids, nullptr, still_, &obstacles_, 0);
}

void Painter::draw_floor() {
  FloorPatch patch(hall_.floor);
  const int width = still_.width;
  // The corners of this row's and the next row's pixels.
  std::vector<Eigen::Vector2d> here(static_cast<std::size_t>(width + 1)), below(here);
  const auto look_at_row = [&](int y, std::vector<Eigen::Vector2d>& places) {
    for (int x = 0; x <= width; ++x)
      places[static_cast<std::size_t>(x)] = camera_.unproject({x, y}, 0).value();
  };
  look_at_row(0, here);
  for (int y = 0; y < still_.height; ++y) {
    look_at_row(y + 1, below);
    constexpr int kStretch = 64;
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      if (x % kStretch == 0) {
        const Eigen::Vector2d& end = here[static_cast<std::size_t>(std::min(x + kStretch, width))];
        const double px_mm = (here[i + 1] - here[i]).norm() + (below[i] - here[i]).norm();
        patch.look_around((here[i] + end) / 2, (end - here[i]).norm() / 2 + 2 * px_mm);
      }
      const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + i;
      bool in_the_way = false;
      still_.pixels[pixel] = patch.color(here[i], here[i + 1] - here[i], below[i] - here[i], in_the_way);
      obstacles_[pixel] = in_the_way ? 1 : 0;
    }
    std::swap(here, below);
  }
}

Painter::Box Painter::box_around(const Sphere& sphere) const {
  Box box{still_.width, still_.height, 0, 0};
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d away((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1,
                               (corner & 4) != 0 ? 1 : -1);
    const auto pixel = camera_.project(sphere.center + away * sphere.radius);
    if (!pixel) return {0, 0, still_.width, still_.height};
    box.left = std::min(box.left, static_cast<int>(std::floor(pixel->x())) - 1);
    box.top = std::min(box.top, static_cast<int>(std::floor(pixel->y())) - 1);
    box.right = std::max(box.right, static_cast<int>(std::ceil(pixel->x())) + 2);
    box.bottom = std::max(box.bottom, static_cast<int>(std::ceil(pixel->y())) + 2);
  }
  return {std::max(box.left, 0), std::max(box.top, 0), std::min(box.right, still_.width),
          std::min(box.bottom, still_.height)};
}

void Painter::draw_solids(std::span<const Solid* const> solids, const LightMap* light, Picture& picture,
                          std::vector<std::uint8_t>* covered, double travel_mm) const {
  std::vector<Box> boxes;
  for (const Solid* solid : solids) {
    const Sphere sphere = solid->bounds();
    boxes.push_back(box_around({sphere.center, sphere.radius + travel_mm}));
  }
  const Sensor& sensor = hall_.sensor;
  const int moments = travel_mm > 0 && sensor.exposure_s > 0 ? kMoments : 1;
  const int rays = covered != nullptr ? kRaysOfFurniture : kRaysOfPlay;
  const auto all = static_cast<float>(rays * rays * moments);
  for (std::size_t i = 0; i < solids.size(); ++i) {
    // A pixel in several boxes is drawn once, by the first box, with everything that may be visible in it.
    std::vector<std::size_t> near;
    for (std::size_t j = 0; j < solids.size(); ++j) {
      if (boxes[i].overlaps(boxes[j])) near.push_back(j);
    }
    for (int y = boxes[i].top; y < boxes[i].bottom; ++y) {
      for (int x = boxes[i].left; x < boxes[i].right; ++x) {
        std::array<const Solid*, 64> here{};
        std::size_t count = 0;
        bool is_drawn = false;
        for (const std::size_t j : near) {
          if (!boxes[j].contains(x, y)) continue;
          is_drawn = is_drawn || j < i;
          if (count < here.size()) here[count++] = solids[j];
        }
        if (is_drawn) continue;
        Color sum = Color::Zero();
        int hits = 0;
        for (int ray_y = 0; ray_y < rays; ++ray_y) {
          for (int ray_x = 0; ray_x < rays; ++ray_x) {
            const Eigen::Vector2d at(x + (ray_x + 0.5) / rays - 0.5, y + (ray_y + 0.5) / rays - 0.5);
            Ray ray{camera_.position_mm(), camera_.ray(at).value()};
            for (int moment = 0; moment < moments; ++moment) {
              ray.time_s = (static_cast<double>(y) / (picture.height - 1) - 0.5) * sensor.readout_s +
                           ((moment + 0.5) / moments - 0.5) * sensor.exposure_s;
              std::optional<Hit> nearest;
              for (std::size_t k = 0; k < count; ++k) {
                const auto hit = here[k]->hit(ray);
                if (hit && hit->along > 0 && (!nearest || hit->along < nearest->along)) nearest = hit;
              }
              if (!nearest) continue;
              sum += nearest->color;
              ++hits;
            }
          }
        }
        if (hits == 0) continue;
        if (light != nullptr) sum *= light->at(x, y);
        const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                                  static_cast<std::size_t>(x);
        picture.pixels[pixel] = picture.pixels[pixel] * (1 - static_cast<float>(hits) / all) + sum / all;
        if (covered != nullptr) (*covered)[pixel] = 1;
      }
    }
  }
}

/// Each lamp casts a soft shadow; in addition, less light reaches the floor right beside an object.
void Painter::cast_shadow(const Eigen::Vector2d& at_mm, double radius_mm, double height_mm,
                          Picture& picture) const {
  const LightFrom light = light_.from(at_mm);
  const Box box = box_around({{at_mm.x(), at_mm.y(), 0}, radius_mm + 1.2 * height_mm + 60});
  std::array<Eigen::Vector2d, 3> ends;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Eigen::Vector3f& d = light.directions[i];
    ends[i] =
        -Eigen::Vector2d(d.x(), d.y()) * std::min(1.2 * height_mm, height_mm / std::max(0.05, double(d.z())));
  }
  for (int y = box.top; y < box.bottom; ++y) {
    for (int x = box.left; x < box.right; ++x) {
      const Eigen::Vector2d p = camera_.unproject({x, y}, 0).value() - at_mm;
      const double outside_mm = std::max(0.0, p.norm() - radius_mm);
      double kept = 0.5 * std::exp(-outside_mm / (0.25 * radius_mm));
      for (std::size_t i = 0; i < ends.size(); ++i) {
        const double along = std::clamp(p.dot(ends[i]) / std::max(1.0, ends[i].squaredNorm()), 0.0, 1.0);
        const double beside_mm = (p - along * ends[i]).norm() - radius_mm;
        const double soft_mm = 8 + 0.35 * height_mm * along;
        kept += light.shares[i] * 0.7 * std::clamp(0.5 - beside_mm / (2 * soft_mm), 0.0, 1.0);
      }
      picture.row(y)[static_cast<std::size_t>(x)] *=
          static_cast<float>(1 - hall_.shadows * std::min(1.0, kept));
    }
  }
}

Picture Painter::frame(const Play& play, int number, double light) {
  Chance chance(hall_.seed, "light", static_cast<std::uint64_t>(number));
  std::vector<double> factors;
  for (std::size_t i = 0; i < hall_.lighting.lamps.size(); ++i) {
    factors.push_back(light * std::max(0.3, 1 + hall_.lighting.lamp_jitter * chance.normal()));
  }
  light_.shine(factors);

  Picture picture = still_;
  for (int y = 0; y < picture.height; ++y) light_.light_row(y, picture.row(y));
  if (hall_.shadows > 0) {
    for (const PlayedRobot& robot : play.robots) {
      cast_shadow(robot.solid.at_mm(), robot.solid.look().radius_mm, robot.solid.look().height_mm, picture);
    }
    for (const PlayedBall& ball : play.balls)
      cast_shadow(ball.at_mm, 0.7 * Ball::kRadiusMm, 2 * Ball::kRadiusMm, picture);
  }

  double fastest_mm_s = 0;
  std::vector<Ball> balls;
  for (const PlayedBall& ball : play.balls) {
    Ball::Look look = hall_.ball;
    look.dimples = static_cast<std::uint32_t>(chance.bits());
    balls.emplace_back(ball.at_mm, look, light_.from(ball.at_mm), ball.motion);
    fastest_mm_s = std::max(fastest_mm_s, ball.motion.velocity_mm_s.norm());
  }
  std::vector<const Solid*> solids;
  for (const PlayedRobot& robot : play.robots) {
    solids.push_back(&robot.solid);
    fastest_mm_s = std::max(fastest_mm_s, robot.solid.motion().velocity_mm_s.norm());
  }
  for (const Ball& ball : balls) solids.push_back(&ball);
  draw_solids(solids, &light_, picture, nullptr,
              fastest_mm_s * (hall_.sensor.exposure_s + hall_.sensor.readout_s) / 2);

  blur(picture, hall_.sensor.blur_px);
  if (hall_.lighting.banding > 0) {
    const double phase = chance.uniform(0, 2 * std::numbers::pi);
    for (int y = 0; y < picture.height; ++y) {
      const double wave = std::sin(2 * std::numbers::pi * y / hall_.lighting.banding_rows + phase);
      for (Color& color : picture.row(y)) color *= static_cast<float>(1 + hall_.lighting.banding * wave);
    }
  }
  return picture;
}

}  // namespace sslv::halls
