// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator_renderer.h"

#include "capture/simulator_random.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace sslv {
namespace {

// Colours under white light at brightness 1, as cameras see a league field's carpet, prints and ball. Chosen
// so that their hues differ by 25 degrees or more in YUV.
struct Paint {
  float r, g, b;
};
constexpr Paint kCarpet{30, 92, 62}, kLine{205, 205, 200}, kFloor{92, 88, 84}, kRobotTop{24, 24, 27},
    kBall{238, 108, 32};
constexpr std::array<Paint, label::kCount> kPrints{{
    {24, 24, 27},     // clear
    {30, 92, 62},     // field
    {238, 108, 32},   // orange
    {224, 198, 38},   // yellow
    {28, 92, 196},    // blue
    {230, 64, 150},   // pink
    {60, 190, 205},   // cyan
    {108, 212, 62},   // green
    {205, 205, 200},  // white
    {24, 24, 27},     // black
}};
constexpr float kFrontPerRadius = 55.0F / 90.0F;  // the flat front of a robot

using Vec2 = Eigen::Vector2f;

/// Share of a pixel's square where an edge's signed distance is positive. `distance` is that of the pixel's
/// centre, `dx` and `dy` its change over one pixel: all in the same unit. Exact for a straight edge.
float covered(float distance, float dx, float dy) {
  const float a = std::max(std::abs(dx), std::abs(dy)), b = std::min(std::abs(dx), std::abs(dy));
  const float far = 0.5F * (a + b), d = std::abs(distance);
  float inside;  // on the side that holds the centre
  if (d >= far) {
    inside = 1;
  } else if (d <= 0.5F * (a - b)) {
    inside = 0.5F + d / a;
  } else {
    inside = 1 - (far - d) * (far - d) / (2 * a * b);
  }
  return distance >= 0 ? inside : 1 - inside;
}

/// Smooth noise in [-0.5, 0.5] over a lattice of `cell_mm`.
float lattice_noise(double x_mm, double y_mm, double cell_mm, std::uint64_t layer) {
  const double x = x_mm / cell_mm, y = y_mm / cell_mm;
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto corner = [&](int dx, int dy) {
    const auto i = static_cast<std::uint64_t>(static_cast<std::int64_t>(x0) + dx);
    const auto j = static_cast<std::uint64_t>(static_cast<std::int64_t>(y0) + dy);
    return static_cast<float>(scatter((i << 32) ^ (j & 0xffffffffU) ^ (layer << 60)) >> 40) * 0x1p-24F - 0.5F;
  };
  const auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  return (corner(0, 0) * (1 - fx) + corner(1, 0) * fx) * (1 - fy) +
         (corner(0, 1) * (1 - fx) + corner(1, 1) * fx) * fy;
}

PixelBox join(const PixelBox& a, const PixelBox& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right),
          std::max(a.bottom, b.bottom)};
}

double lowest_mm(const SimulatedScene& scene) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const SimulatedRobot& robot : scene.robots) lowest = std::min(lowest, robot.height_mm);
  return lowest;
}

/// To a LightPicture's channel: rounded, and no more than it can hold.
std::uint16_t channel_value(float steps) {
  const float up = std::min(steps, 65535.0F) + 0.5F;
  return static_cast<std::uint16_t>(up);
}

}  // namespace

/// A thing's place as seen from the pixels of one box: its centre, and the turn into its own frame.
struct SimulatorRenderer::Shape {
  Eigen::Vector2d center_mm;
  float cos = 1, sin = 0;

  Vec2 into(const Vec2& v) const { return {cos * v.x() + sin * v.y(), -sin * v.x() + cos * v.y()}; }
};

struct SimulatorRenderer::Footprint {
  Vec2 dx, dy;  // mm on the plane per pixel to the right and downwards
  float reach;  // no point of the pixel's square is further from its centre than this, mm

  Footprint(const Vec2& right, const Vec2& down)
      : dx(right), dy(down), reach(0.5F * (right.norm() + down.norm())) {}

  /// Share of the pixel inside a disc.
  float in_disc(const Vec2& from_center, float radius) const {
    const float r = std::max(from_center.norm(), 1e-6F);
    if (r >= radius + reach) return 0;
    if (r <= radius - reach) return 1;
    return covered(radius - r, from_center.dot(dx) / r, from_center.dot(dy) / r);
  }
  /// Share of the pixel where v < limit; `v` and its change per mm along the plane's axes are given.
  float below(float limit, float v, const Vec2& gradient) const {
    return covered(limit - v, gradient.dot(dx), gradient.dot(dy));
  }
  /// Share of the pixel within `half_width` of a line; `v` is the distance from it.
  float in_strip(float half_width, float v, const Vec2& gradient) const {
    if (std::abs(v) >= half_width + reach) return 0;
    return below(half_width, v, gradient) - below(-half_width, v, gradient);
  }
};

struct SimulatorRenderer::Coat {
  float opacity = 0;
  float r = 0, g = 0, b = 0;  // already weighted by how much of the pixel they cover

  void add(const Paint& paint, float share) {
    r += paint.r * share;
    g += paint.g * share;
    b += paint.b * share;
  }
};

SimulatorRenderer::SimulatorRenderer(const SimulatorOptions& options, const FieldSize& field,
                                     const CameraModel& camera, const PatternTable& patterns)
    : options_(options),
      field_(field),
      lines_(field_lines(field)),
      arcs_(field_arcs(field)),
      camera_(camera),
      patterns_(patterns) {}

float SimulatorRenderer::light_at(int x, int y) const {
  const double across = x / std::max(1.0, options_.width - 1.0);
  const double cx = (options_.width - 1) / 2.0, cy = (options_.height - 1) / 2.0;
  const double r2 = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (cx * cx + cy * cy);
  return static_cast<float>(options_.light * (1 - options_.gradient * across) * (1 - options_.vignette * r2));
}

SimulatorRenderer::Footprint SimulatorRenderer::footprint_at(const Eigen::Vector2d& pixel,
                                                             double height_mm) const {
  const auto at = [&](double dx, double dy) {
    return camera_.unproject(pixel + Eigen::Vector2d(dx, dy), height_mm).value_or(Eigen::Vector2d::Zero());
  };
  return {(at(0.5, 0) - at(-0.5, 0)).cast<float>(), (at(0, 0.5) - at(0, -0.5)).cast<float>()};
}

SimulatorRenderer::Color SimulatorRenderer::carpet_at(const Eigen::Vector2d& p) const {
  const double half_x = field_.field_length / 2.0 + field_.boundary_width_goal_line;
  const double half_y = field_.field_width / 2.0 + field_.boundary_width;
  const bool on_carpet = std::abs(p.x()) <= half_x && std::abs(p.y()) <= half_y;
  const Paint& paint = on_carpet ? kCarpet : kFloor;
  // Pile and wear.
  const float tone =
      1 + 0.10F * lattice_noise(p.x(), p.y(), 14, 1) + 0.12F * lattice_noise(p.x(), p.y(), 350, 2);
  return {paint.r * tone, paint.g * tone, paint.b * tone};
}

float SimulatorRenderer::lines_at(const Eigen::Vector2d& field_mm, const Footprint& footprint) const {
  const float half = static_cast<float>(field_.line_thickness) / 2;
  float share = 0;
  for (const FieldLine& line : lines_) {
    const Eigen::Vector2d from(line.x1, line.y1), to(line.x2, line.y2);
    const double length = (to - from).norm();
    if (length <= 0) continue;
    const Eigen::Vector2d along = (to - from) / length, across(-along.y(), along.x());
    const Eigen::Vector2d rel = field_mm - (from + to) / 2;
    const float on_width =
        footprint.in_strip(half, static_cast<float>(rel.dot(across)), across.cast<float>());
    if (on_width <= 0) continue;
    // The paint ends half a width beyond the end points, so that corners are square.
    const float on_length = footprint.in_strip(static_cast<float>(length) / 2 + half,
                                               static_cast<float>(rel.dot(along)), along.cast<float>());
    share = std::max(share, on_width * on_length);
  }
  for (const FieldArc& arc : arcs_) {
    const Eigen::Vector2d rel = field_mm - Eigen::Vector2d(arc.x, arc.y);
    const double r = rel.norm();
    if (r <= 0) continue;
    double turn = std::atan2(rel.y(), rel.x()) - arc.a1;
    turn -= 2 * std::numbers::pi * std::floor(turn / (2 * std::numbers::pi));
    if (turn > arc.a2 - arc.a1) continue;
    share = std::max(share,
                     footprint.in_strip(half, static_cast<float>(r - arc.radius), (rel / r).cast<float>()));
  }
  return share;
}

LightPicture SimulatorRenderer::background() const {
  LightPicture picture(options_.width, options_.height);
  constexpr int kBlock = 16;  // pixels of a row that share a footprint
  for (int y = 0; y < picture.height; ++y) {
    Footprint footprint(Vec2::Zero(), Vec2::Zero());
    for (int x = 0; x < picture.width; ++x) {
      if (x % kBlock == 0) footprint = footprint_at(Eigen::Vector2d(x + kBlock / 2, y), 0);
      Color color{kFloor.r, kFloor.g, kFloor.b};
      if (const auto p = camera_.unproject(Eigen::Vector2d(x, y), 0)) {
        color = carpet_at(*p);
        const float line = lines_at(*p, footprint);
        color.r += (kLine.r - color.r) * line;
        color.g += (kLine.g - color.g) * line;
        color.b += (kLine.b - color.b) * line;
      }
      const float light = light_at(x, y) * LightPicture::kPerGrey;
      std::uint16_t* out = picture.at(x, y);
      out[0] = channel_value(color.r * light * static_cast<float>(options_.red_gain));
      out[1] = channel_value(color.g * light);
      out[2] = channel_value(color.b * light * static_cast<float>(options_.blue_gain));
    }
  }
  return picture;
}

/// Pixels that may show a flat disc; empty when it is out of sight.
PixelBox SimulatorRenderer::box_around(const Eigen::Vector3d& center_mm, double radius_mm) const {
  constexpr int kPoints = 16;
  double left = std::numeric_limits<double>::infinity(), top = left, right = -left, bottom = -left;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = i * 2 * std::numbers::pi / kPoints;
    const auto pixel =
        camera_.project(center_mm + radius_mm * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0));
    if (!pixel) continue;
    left = std::min(left, pixel->x());
    right = std::max(right, pixel->x());
    top = std::min(top, pixel->y());
    bottom = std::max(bottom, pixel->y());
  }
  const auto clamped = [](double value, int size) {
    return static_cast<int>(std::clamp<double>(value, 0, size));
  };
  // One pixel of margin for the polygon's and one for the pixels' own width.
  return {clamped(left - 2, options_.width), clamped(top - 2, options_.height),
          clamped(right + 3, options_.width), clamped(bottom + 3, options_.height)};
}

template <class CoatOf>
void SimulatorRenderer::paint(const PixelBox& box, double height_mm, std::span<const Shape> shapes,
                              const CoatOf& coat_of, LightPicture& picture) const {
  const float weight = 1 / static_cast<float>(shapes.size());
  const Footprint plane =
      footprint_at({0.5 * (box.left + box.right - 1), 0.5 * (box.top + box.bottom - 1)}, height_mm);
  const auto red = static_cast<float>(options_.red_gain), blue = static_cast<float>(options_.blue_gain);
  for (int y = box.top; y < box.bottom; ++y) {
    for (int x = box.left; x < box.right; ++x) {
      const auto p = camera_.unproject(Eigen::Vector2d(x, y), height_mm);
      if (!p) continue;
      Coat coat;
      for (const Shape& shape : shapes) {
        // The footprint changes little over a box, and only the width of soft edges depends on it.
        coat_of(shape.into((*p - shape.center_mm).cast<float>()),
                Footprint(shape.into(plane.dx), shape.into(plane.dy)), coat);
      }
      if (coat.opacity <= 0) continue;
      const float light = light_at(x, y) * weight * LightPicture::kPerGrey;
      const float rest = 1 - coat.opacity * weight;
      std::uint16_t* out = picture.at(x, y);
      const auto mix = [&](std::uint16_t& channel, float ink) {
        channel = channel_value(channel * rest + ink * light);
      };
      mix(out[0], coat.r * red);
      mix(out[1], coat.g);
      mix(out[2], coat.b * blue);
    }
  }
}

void SimulatorRenderer::draw_robot(std::span<const SimulatedScene> moments, std::size_t index,
                                   LightPicture& picture, Boxes& boxes) const {
  const SimulatedRobot& robot = moments.front().robots[index];
  const auto radius = static_cast<float>(field_.max_robot_radius);
  const float front = radius * kFrontPerRadius;
  const float center_radius = static_cast<float>(patterns_.center_diameter_mm) / 2;
  const float dot_radius = static_cast<float>(patterns_.dot_diameter_mm) / 2;
  const Paint& team = kPrints[robot.team == Team::kBlue ? label::kBlue : label::kYellow];
  const auto code = std::find_if(patterns_.codes.begin(), patterns_.codes.end(),
                                 [&](const PatternTable::Code& c) { return c.id == robot.id; });

  boost::container::static_vector<Shape, kMaxMoments> shapes;
  PixelBox box{options_.width, options_.height, 0, 0};
  for (const SimulatedScene& moment : moments) {
    const SimulatedRobot& r = moment.robots[index];
    shapes.push_back({{r.x_mm, r.y_mm},
                      static_cast<float>(std::cos(r.orientation_rad)),
                      static_cast<float>(std::sin(r.orientation_rad))});
    box = join(box, box_around({r.x_mm, r.y_mm, r.height_mm}, field_.max_robot_radius));
  }
  if (box.empty()) return;
  boxes.push_back(box);

  const auto coat_of = [&](const Vec2& p, const Footprint& footprint, Coat& coat) {
    const float top = footprint.in_disc(p, radius) * footprint.below(front, p.x(), Vec2(1, 0));
    if (top <= 0) return;
    float printed = 0;
    const auto print = [&](const Vec2& from_center, float dot_radius_mm, const Paint& paint) {
      const float share = footprint.in_disc(from_center, dot_radius_mm);
      coat.add(paint, share);
      printed += share;
    };
    print(p, center_radius, team);
    for (std::size_t dot = 0; dot < patterns_.dots.size(); ++dot) {
      const Vec2 center(static_cast<float>(patterns_.dots[dot].x_mm),
                        static_cast<float>(patterns_.dots[dot].y_mm));
      print(p - center, dot_radius, kPrints[code->colors[dot]]);
    }
    // Dots lie inside the outline, so what they leave of the top's share is black, also where both edges
    // cross a pixel.
    coat.add(kRobotTop, std::max(0.0F, top - printed));
    coat.opacity += std::max(top, std::min(printed, 1.0F));
  };
  paint(box, robot.height_mm, {shapes.data(), shapes.size()}, coat_of, picture);
}

void SimulatorRenderer::draw_ball(std::span<const SimulatedScene> moments, std::size_t index,
                                  LightPicture& picture, Boxes& boxes) const {
  const auto radius = static_cast<float>(field_.ball_radius);
  boost::container::static_vector<Shape, kMaxMoments> shapes;
  PixelBox box{options_.width, options_.height, 0, 0};
  for (const SimulatedScene& moment : moments) {
    const SimulatedBall& ball = moment.balls[index];
    shapes.push_back({{ball.x_mm, ball.y_mm}});
    box = join(box, box_around({ball.x_mm, ball.y_mm, field_.ball_radius}, field_.ball_radius));
  }
  if (box.empty()) return;
  boxes.push_back(box);

  const auto coat_of = [&](const Vec2& p, const Footprint& footprint, Coat& coat) {
    const float share = footprint.in_disc(p, radius);
    // Lit from above: brightest where its surface is level.
    const float level = std::sqrt(std::max(0.0F, 1 - p.squaredNorm() / (radius * radius)));
    coat.add(kBall, share * (0.7F + 0.35F * level));
    coat.opacity += share;
  };
  paint(box, field_.ball_radius, {shapes.data(), shapes.size()}, coat_of, picture);
}

void SimulatorRenderer::draw(std::span<const SimulatedScene> moments, LightPicture& picture,
                             Boxes& boxes) const noexcept {
  boxes.clear();
  const SimulatedScene& scene = moments.front();
  for (std::size_t i = 0; i < scene.balls.size(); ++i) draw_ball(moments, i, picture, boxes);
  // A higher top hides a lower one. There are two heights, one for each team.
  const double lowest = lowest_mm(scene);
  for (const bool higher : {false, true}) {
    for (std::size_t i = 0; i < scene.robots.size(); ++i) {
      if ((scene.robots[i].height_mm > lowest) == higher) draw_robot(moments, i, picture, boxes);
    }
  }
}

}  // namespace sslv
