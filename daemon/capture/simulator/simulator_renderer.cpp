// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_renderer.h"

#include "capture/simulator/simulator_texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace sslv {
namespace {

constexpr Paint kLine{205, 205, 200}, kNowhere{92, 88, 84}, kRobotTop{24, 24, 27}, kRobotSide{34, 34, 38},
    kLampSpot{260, 255, 235};
/// Unit vector towards the lamp of `ball_gloss`.
const Eigen::Vector3f kLampDirection = Eigen::Vector3f(0.5F, 0.35F, 1).normalized();

constexpr int kGridPx = 16;         // spacing of LampGrid
constexpr float kMarginPx = 0.75F;  // slightly more than the distance from a pixel's centre to its corners
constexpr auto kEverywhere = [](int /*x*/, int /*y*/) { return true; };

using Vec2 = Eigen::Vector2f;

/// Fraction of a pixel's square on the positive side of an edge. `distance` is the signed distance of the
/// pixel's centre, `dx` and `dy` its change over one pixel, all in the same unit. Exact for a straight edge.
float covered(float distance, float dx, float dy) {
  const float a = std::max(std::abs(dx), std::abs(dy)), b = std::min(std::abs(dx), std::abs(dy));
  const float far = 0.5F * (a + b), d = std::abs(distance);
  float inside;  // fraction on the side that holds the centre
  if (d >= far) {
    inside = 1;
  } else if (d <= 0.5F * (a - b)) {
    inside = 0.5F + d / a;
  } else {
    inside = 1 - (far - d) * (far - d) / (2 * a * b);
  }
  return distance >= 0 ? inside : 1 - inside;
}

DrawnBox join(const DrawnBox& a, const DrawnBox& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right),
          std::max(a.bottom, b.bottom)};
}

/// Converts to a value of a LightPicture's channel, rounded and limited to the maximum.
std::uint16_t channel_value(float steps) {
  const float up = std::min(steps, 65535.0F) + 0.5F;
  return static_cast<std::uint16_t>(up);
}

}  // namespace

/// An object's pose while one box is rendered: centre, and rotation into the object's frame.
struct SimulatorRenderer::Shape {
  Eigen::Vector2d center_mm;
  float cos = 1, sin = 0;
  Vec2 eye{0, 0};  // the point below the camera, in the thing's frame

  Vec2 into(const Vec2& v) const { return {cos * v.x() + sin * v.y(), -sin * v.x() + cos * v.y()}; }
  /// The shape dt_s later; `eye_mm` is the point below the camera.
  Shape moved(const SimulatorMotion& motion, double dt_s, const Eigen::Vector2d& eye_mm) const {
    const auto turn = static_cast<float>(motion.turn_rad(dt_s));
    const float c = std::cos(turn), s = std::sin(turn);
    Shape out{center_mm + motion.way_mm(dt_s), cos * c - sin * s, sin * c + cos * s};
    out.eye = out.into((eye_mm - out.center_mm).cast<float>());
    return out;
  }
};

struct SimulatorRenderer::Footprint {
  Vec2 dx, dy;  // mm on the plane per pixel to the right and downwards
  float reach;  // maximum distance of the pixel's square from its centre, mm

  Footprint(const Vec2& right, const Vec2& down)
      : dx(right), dy(down), reach(0.5F * (right.norm() + down.norm())) {}

  /// Fraction of the pixel inside a disc.
  float in_disc(const Vec2& from_center, float radius) const {
    const float r2 = from_center.squaredNorm();
    if (r2 >= (radius + reach) * (radius + reach)) return 0;
    if (reach <= radius && r2 <= (radius - reach) * (radius - reach)) return 1;
    const float r = std::max(std::sqrt(r2), 1e-6F);
    return covered(radius - r, from_center.dot(dx) / r, from_center.dot(dy) / r);
  }
  /// Fraction of the pixel inside an ellipse or rectangle with half axes a and b.
  float in_ellipse(const Vec2& p, float a, float b) const {
    // `r` is 1 on the rim; near the rim, `r` - 1 is proportional to the distance from the rim.
    const Vec2 scaled(p.x() / a, p.y() / b);
    const float r = std::max(scaled.norm(), 1e-6F);
    return below(1, r, Vec2(scaled.x() / (a * r), scaled.y() / (b * r)));
  }
  float in_rectangle(const Vec2& p, float a, float b) const {
    return in_strip(a, p.x(), Vec2(1, 0)) * in_strip(b, p.y(), Vec2(0, 1));
  }
  /// Fraction of the pixel whose line of sight meets a robot's outline; seen from above, the line runs from
  /// `p` to `q`.
  float in_outline(const Vec2& p, const Vec2& q, float radius, float front) const {
    const Vec2 d = q - p;
    const auto round = [&](float t) { return (p + t * d).norm() - radius; };
    const auto flat = [&](float t) { return p.x() + t * d.x() - front; };
    // The line's distance from the outline is the minimum over t of the larger of the two edge distances.
    // That value is reached at the minimum of one of them, or between these two minima, where both distances
    // are equal.
    const float roundest = std::clamp(-p.dot(d) / std::max(d.squaredNorm(), 1e-6F), 0.0F, 1.0F);
    const Vec2 nearest = p + roundest * d;
    const float r2 = nearest.squaredNorm();
    if (r2 >= (radius + reach) * (radius + reach)) return 0;
    if (reach <= radius && r2 <= (radius - reach) * (radius - reach) && nearest.x() <= front - reach)
      return 1;
    const float flattest = d.x() < 0 ? 1 : 0;
    if (flat(flattest) >= reach) return 0;
    float t = flattest;
    if (round(roundest) >= flat(roundest)) {
      t = roundest;
    } else if (round(flattest) > flat(flattest)) {
      float flat_greater = roundest;
      for (int i = 0; i < 8; ++i) {
        const float middle = (flat_greater + t) / 2;
        (round(middle) > flat(middle) ? t : flat_greater) = middle;
      }
    }
    if (round(t) < flat(t)) return below(0, flat(t), Vec2(1, 0));
    const Vec2 outwards = (p + t * d).normalized();
    return below(0, round(t), outwards);
  }
  /// Fraction of the pixel where v < limit; `gradient` is the change of `v` per mm along the plane's axes.
  float below(float limit, float v, const Vec2& gradient) const {
    return covered(limit - v, gradient.dot(dx), gradient.dot(dy));
  }
  /// Fraction of the pixel within `half_width` of a line; `v` is the distance of the pixel's centre from the
  /// line.
  float in_strip(float half_width, float v, const Vec2& gradient) const {
    if (std::abs(v) >= half_width + reach) return 0;
    return below(half_width, v, gradient) - below(-half_width, v, gradient);
  }
};

struct SimulatorRenderer::Spot {
  DrawnBox box;  // may extend beyond the image; empty if the camera cannot see the disc
  Vec2 middle;
  float reach_px;  // maximum distance of the disc from the middle
};

struct SimulatorRenderer::Coat {
  float opacity = 0;
  float r = 0, g = 0, b = 0;  // light of the paints, weighted by their coverage of the pixel

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
      markings_(measured_to_middle(field, options.lines_measured_to)),
      camera_(camera),
      patterns_(patterns),
      lamps_(resolved(options.hall), field),
      carpet_(resolved(options.hall), field, lamps_),
      surroundings_(resolved(options.hall), field),
      prints_(resolved(options.hall)),
      shadows_(static_cast<float>(resolved(options.hall).lamps.shadows.value())),
      lamp_grid_(lamps_, camera_, options.width, options.height) {}

SimulatorRenderer::LampGrid::LampGrid(const SimulatedLamps& lamps, const CameraModel& camera, int width,
                                      int height) {
  if (lamps.even()) return;
  columns_ = (width - 1) / kGridPx + 2;
  const int rows = (height - 1) / kGridPx + 2;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns_; ++x) {
      const auto place = camera.unproject(Eigen::Vector2d(x * kGridPx, y * kGridPx), 0);
      lights_.push_back(place ? lamps.at(*place) : Paint{1, 1, 1});
    }
  }
}

Paint SimulatorRenderer::LampGrid::at(int x, int y) const {
  if (lights_.empty()) return {1, 1, 1};
  const Paint* upper = lights_.data() + static_cast<std::ptrdiff_t>(y / kGridPx) * columns_ + x / kGridPx;
  const Paint* lower = upper + columns_;
  const float fx = static_cast<float>(x % kGridPx) / kGridPx, fy = static_cast<float>(y % kGridPx) / kGridPx;
  return upper[0].mixed(upper[1], fx).mixed(lower[0].mixed(lower[1], fx), fy);
}

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

float SimulatorRenderer::lines_at(const Eigen::Vector2d& field_mm, const Footprint& footprint) const {
  float share = 0;
  for (const FieldLine& line : markings_.lines) {
    const float half = static_cast<float>(line.thickness) / 2;
    const Eigen::Vector2d from(line.x1, line.y1), to(line.x2, line.y2);
    const double length = (to - from).norm();
    if (length <= 0) continue;
    const Eigen::Vector2d along = (to - from) / length, across(-along.y(), along.x());
    const Eigen::Vector2d rel = field_mm - (from + to) / 2;
    const float on_width =
        footprint.in_strip(half, static_cast<float>(rel.dot(across)), across.cast<float>());
    if (on_width <= 0) continue;
    // The paint extends half a width beyond the end points, so that corners are square.
    const float on_length = footprint.in_strip(static_cast<float>(length) / 2 + half,
                                               static_cast<float>(rel.dot(along)), along.cast<float>());
    share = std::max(share, on_width * on_length);
  }
  for (const FieldArc& arc : markings_.arcs) {
    const Eigen::Vector2d rel = field_mm - Eigen::Vector2d(arc.x, arc.y);
    const double r = rel.norm();
    if (r <= 0) continue;
    double turn = std::atan2(rel.y(), rel.x()) - arc.a1;
    turn -= 2 * std::numbers::pi * std::floor(turn / (2 * std::numbers::pi));
    if (turn > arc.a2 - arc.a1) continue;
    const float half = static_cast<float>(arc.thickness) / 2;
    share = std::max(share,
                     footprint.in_strip(half, static_cast<float>(r - arc.radius), (rel / r).cast<float>()));
  }
  return share;
}

Paint SimulatorRenderer::floor_at(const Eigen::Vector2d& p, const Footprint& footprint) const {
  Paint color = surroundings_.on_carpet(p) ? carpet_.at(p, camera_.position_mm()) : surroundings_.floor_at(p);
  color = color.mixed(kLine, lines_at(p, footprint));
  const float shade = surroundings_.shade_at(p);
  return shade == 1 ? color : color.scaled(shade);
}

/// The colour of a pixel in which boards hide the floor; nothing if no board hides it.
std::optional<Paint> SimulatorRenderer::boards_at(int x, int y, const Paint& floor) const {
  constexpr int kSamples = 2;  // samples per direction, because letters and edges are small
  Paint sum{0, 0, 0};
  int hits = 0;
  for (int i = 0; i < kSamples * kSamples; ++i) {
    const Eigen::Vector2d at(x + (i % kSamples + 0.5) / kSamples - 0.5,
                             y + (static_cast<double>(i) / kSamples + 0.25) / kSamples - 0.5);
    const auto p = camera_.unproject(at, 0);
    const auto board = p ? surroundings_.board_before(*p, camera_.position_mm()) : std::nullopt;
    const Paint& color = board ? *board : floor;
    sum = {sum.r + color.r, sum.g + color.g, sum.b + color.b};
    hits += board.has_value();
  }
  if (hits == 0) return std::nullopt;
  return sum.scaled(1.0F / (kSamples * kSamples));
}

LightPicture SimulatorRenderer::background(const SimulatedScene& scene) const {
  LightPicture picture(options_.width, options_.height);
  constexpr int kBlock = 16;  // pixels of a row that share a footprint
  for (int y = 0; y < picture.height; ++y) {
    Footprint footprint(Vec2::Zero(), Vec2::Zero());
    for (int x = 0; x < picture.width; ++x) {
      if (x % kBlock == 0) footprint = footprint_at(Eigen::Vector2d(x + kBlock / 2, y), 0);
      Paint color = kNowhere;
      if (const auto p = camera_.unproject(Eigen::Vector2d(x, y), 0)) {
        color = floor_at(*p, footprint);
        if (surroundings_.has_boards() && !surroundings_.on_carpet(*p))
          color = boards_at(x, y, color).value_or(color);
      }
      const float light = light_at(x, y) * LightPicture::kPerGrey;
      const Paint lamps = lamp_grid_.at(x, y);
      std::uint16_t* out = picture.at(x, y);
      out[0] = channel_value(color.r * light * static_cast<float>(options_.red_gain) * lamps.r);
      out[1] = channel_value(color.g * light * lamps.g);
      out[2] = channel_value(color.b * light * static_cast<float>(options_.blue_gain) * lamps.b);
    }
  }
  for (const SimulatedSurroundings::Slice& slice : surroundings_.slices()) draw_slice(slice, picture);
  for (const SimulatedDistractor& distractor : scene.distractors) draw_distractor(distractor, picture);
  return picture;
}

SimulatorRenderer::Spot SimulatorRenderer::spot_of(const Eigen::Vector3d& center_mm, double radius_mm) const {
  // An octagon around the disc.
  static const auto kCorners = [] {
    std::array<Eigen::Vector3d, 8> out;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double angle = static_cast<double>(i) * std::numbers::pi / 4;
      out[i] = Eigen::Vector3d(std::cos(angle), std::sin(angle), 0) / std::cos(std::numbers::pi / 8);
    }
    return out;
  }();
  constexpr double kFar = std::numeric_limits<double>::infinity();
  double left = kFar, top = kFar, right = -kFar, bottom = -kFar;
  Spot spot{{}, Vec2::Zero(), 0};
  const auto middle = camera_.project(center_mm);
  if (middle) spot.middle = middle->cast<float>();
  for (const Eigen::Vector3d& corner : kCorners) {
    const auto pixel = camera_.project(center_mm + radius_mm * corner);
    if (!middle || !pixel) spot.reach_px = std::numeric_limits<float>::infinity();
    if (!pixel) continue;
    left = std::min(left, pixel->x());
    right = std::max(right, pixel->x());
    top = std::min(top, pixel->y());
    bottom = std::max(bottom, pixel->y());
    spot.reach_px = std::max(spot.reach_px, (pixel->cast<float>() - spot.middle).norm() + kMarginPx);
  }
  const auto whole = [](double value) { return static_cast<int>(std::clamp(value, -1e6, 1e6)); };
  spot.box = {whole(std::ceil(left - kMarginPx)), whole(std::ceil(top - kMarginPx)),
              whole(std::floor(right + kMarginPx) + 1), whole(std::floor(bottom + kMarginPx) + 1)};
  return spot;
}

/// The bounding box of a disc at the read-out times of all rows.
DrawnBox SimulatorRenderer::box_of(const Eigen::Vector3d& center_mm, double radius_mm,
                                   const SimulatorMotion* motion) const {
  if (motion == nullptr) return spot_of(center_mm, radius_mm).box;
  DrawnBox box{};
  for (const int row : {0, (options_.height - 1) / 2, options_.height - 1}) {
    const Eigen::Vector2d way_mm = motion->way_mm(row_delay_s(row));
    box = join(box, spot_of(center_mm + Eigen::Vector3d(way_mm.x(), way_mm.y(), 0), radius_mm).box);
  }
  return box;
}

double SimulatorRenderer::row_delay_s(double y) const {
  return (y / std::max(1, options_.height - 1) - 0.5) * options_.rolling_shutter_ms * 1e-3;
}

DrawnBox SimulatorRenderer::in_picture(const DrawnBox& box) const {
  return {std::max(box.left, 0), std::max(box.top, 0), std::min(box.right, options_.width),
          std::min(box.bottom, options_.height)};
}

template <class CoatOf, class MayShow>
void SimulatorRenderer::paint(const DrawnBox& box, double height_mm, std::span<const Shape> shapes,
                              const CoatOf& coat_of, const MayShow& may_show, LightPicture& picture,
                              const SimulatorMotion* motion) const {
  const float weight = 1 / static_cast<float>(shapes.size());
  const Footprint plane =
      footprint_at({0.5 * (box.left + box.right - 1), 0.5 * (box.top + box.bottom - 1)}, height_mm);
  // The footprint changes little over a box, and affects only the width of soft edges.
  boost::container::static_vector<Footprint, kMaxMoments> footprints;
  for (const Shape& shape : shapes) footprints.emplace_back(shape.into(plane.dx), shape.into(plane.dy));
  boost::container::static_vector<Shape, kMaxMoments> in_row;  // the shapes at the row's read-out time
  if (motion != nullptr) in_row.assign(shapes.begin(), shapes.end());
  const std::span<const Shape> seen = motion != nullptr ? std::span(in_row.data(), in_row.size()) : shapes;
  const auto red = static_cast<float>(options_.red_gain), blue = static_cast<float>(options_.blue_gain);
  for (int y = box.top; y < box.bottom; ++y) {
    for (std::size_t i = 0; i < in_row.size(); ++i)
      in_row[i] = shapes[i].moved(*motion, row_delay_s(y), camera_.position_mm().head<2>());
    for (int x = box.left; x < box.right; ++x) {
      if (!may_show(x, y)) continue;
      const auto p = camera_.unproject(Eigen::Vector2d(x, y), height_mm);
      if (!p) continue;
      Coat coat;
      for (std::size_t i = 0; i < shapes.size(); ++i) {
        coat_of(seen[i].into((*p - seen[i].center_mm).cast<float>()), footprints[i], seen[i], coat);
      }
      if (coat.opacity <= 0) continue;
      const float light = light_at(x, y) * weight * LightPicture::kPerGrey;
      const Paint lamps = lamp_grid_.at(x, y);
      const float rest = 1 - coat.opacity * weight;
      std::uint16_t* out = picture.at(x, y);
      const auto mix = [&](std::uint16_t& channel, float ink) {
        channel = channel_value(channel * rest + ink * light);
      };
      mix(out[0], coat.r * red * lamps.r);
      mix(out[1], coat.g * lamps.g);
      mix(out[2], coat.b * blue * lamps.b);
    }
  }
}

/// Returns the box that was drawn, which may be empty.
DrawnBox SimulatorRenderer::draw_distractor(const SimulatedDistractor& d, LightPicture& picture) const {
  const auto a = static_cast<float>(d.length_mm / 2), b = static_cast<float>(d.width_mm / 2);
  const DrawnBox box = in_picture(spot_of({d.x_mm, d.y_mm, 0}, std::hypot(a, b)).box);
  if (box.empty()) return box;
  const Shape shape{
      {d.x_mm, d.y_mm}, static_cast<float>(std::cos(d.turn_rad)), static_cast<float>(std::sin(d.turn_rad))};
  const auto share_of = [&](const Vec2& p, const Footprint& footprint) {
    switch (d.shape) {
      case SimulatedDistractor::Shape::kEllipse: return footprint.in_ellipse(p, a, b);
      case SimulatedDistractor::Shape::kRectangle: return footprint.in_rectangle(p, a, b);
      case SimulatedDistractor::Shape::kTriangle: {
        // The base is at -a, the tip at a.
        const Vec2 side = Vec2(b, 2 * a).normalized(), other(side.x(), -side.y());
        const float limit = side.x() * a;
        return footprint.below(a, -p.x(), Vec2(-1, 0)) * footprint.below(limit, p.dot(side), side) *
               footprint.below(limit, p.dot(other), other);
      }
    }
    return 0.0F;
  };
  const auto coat_of = [&](const Vec2& p, const Footprint& footprint, const Shape& /*shape*/, Coat& coat) {
    const float share = share_of(p, footprint);
    coat.add(kPrints[d.paint], share);
    coat.opacity += share;
  };
  paint(box, 0, {&shape, 1}, coat_of, kEverywhere, picture);
  return box;
}

void SimulatorRenderer::draw_slice(const SimulatedSurroundings::Slice& slice, LightPicture& picture) const {
  const Eigen::Vector3d& center = slice.center_mm;
  if (center.z() >= camera_.position_mm().z()) return;
  const auto a = static_cast<float>(slice.half_length_mm), b = static_cast<float>(slice.half_width_mm);
  const DrawnBox box = in_picture(spot_of(center, std::hypot(a, b)).box);
  if (box.empty()) return;
  const Shape shape{center.head<2>(), static_cast<float>(std::cos(slice.turn_rad)),
                    static_cast<float>(std::sin(slice.turn_rad))};
  const auto coat_of = [&](const Vec2& p, const Footprint& footprint, const Shape& /*shape*/, Coat& coat) {
    const float share = slice.is_round ? footprint.in_ellipse(p, a, b) : footprint.in_rectangle(p, a, b);
    coat.add(slice.paint, share);
    coat.opacity += share;
  };
  const bool may_be_hidden = surroundings_.has_boards() && surroundings_.is_behind_boards(center.head<2>());
  const auto may_show = [&](int x, int y) {
    if (!may_be_hidden) return true;
    const auto floor = camera_.unproject(Eigen::Vector2d(x, y), 0);
    return !floor || !surroundings_.board_before(*floor, camera_.position_mm());
  };
  paint(box, center.z(), {&shape, 1}, coat_of, may_show, picture);
}

void SimulatorRenderer::draw_robot(std::span<const SimulatedScene> moments, std::size_t index,
                                   const SimulatorMotion* motion, LightPicture& picture, Boxes& boxes) const {
  const SimulatedRobot& robot = moments.front().robots[index];
  const auto radius = static_cast<float>(field_.max_robot_radius);
  const float front = radius * static_cast<float>(kRobotFrontPerRadius);
  const Vec2 center_dot(static_cast<float>(patterns_.center_x_mm), static_cast<float>(patterns_.center_y_mm));
  const float center_radius = static_cast<float>(patterns_.center_diameter_mm) / 2;
  const SimulatedPrints::Colors& colors = prints_.of(robot.team, robot.id);
  const Paint& team = colors[robot.team == Team::kBlue ? label::kBlue : label::kYellow];
  const Eigen::Vector3d& eye = camera_.position_mm();
  if (eye.z() <= robot.height_mm) return;  // the top is not visible
  const auto down = static_cast<float>(robot.height_mm / (eye.z() - robot.height_mm));
  const auto code = std::find_if(patterns_.codes.begin(), patterns_.codes.end(),
                                 [&](const PatternTable::Code& c) { return c.id == robot.id; });

  boost::container::static_vector<Shape, kMaxMoments> shapes;
  DrawnBox box{};
  Spot top{}, foot{};
  for (const SimulatedScene& moment : moments) {
    const SimulatedRobot& r = moment.robots[index];
    Shape& shape = shapes.emplace_back(Shape{{r.x_mm, r.y_mm},
                                             static_cast<float>(std::cos(r.orientation_rad)),
                                             static_cast<float>(std::sin(r.orientation_rad))});
    shape.eye = shape.into((eye.head<2>() - shape.center_mm).cast<float>());
    top = spot_of({r.x_mm, r.y_mm, r.height_mm}, field_.max_robot_radius);
    foot = spot_of({r.x_mm, r.y_mm, 0}, field_.max_robot_radius);
    box = join(box, join(top.box, foot.box));
    if (motion != nullptr) {
      box = join(box, join(box_of({r.x_mm, r.y_mm, r.height_mm}, field_.max_robot_radius, motion),
                           box_of({r.x_mm, r.y_mm, 0}, field_.max_robot_radius, motion)));
    }
  }
  box = in_picture(box);
  if (box.empty()) return;
  boxes.push_back(box);

  const auto coat_of = [&](const Vec2& p, const Footprint& footprint, const Shape& shape, Coat& coat) {
    float lid = footprint.in_disc(p, radius);
    if (lid > 0 && p.x() > front - footprint.reach) lid *= footprint.below(front, p.x(), Vec2(1, 0));
    // The line of sight continues from the top's plane to the floor.
    const float body = lid < 1 ? footprint.in_outline(p, p + down * (p - shape.eye), radius, front) : 1;
    if (lid <= 0) {
      coat.add(kRobotSide, body);
      coat.opacity += body;
      return;
    }
    float printed = 0;
    const auto print = [&](const Vec2& from_center, float dot_radius_mm, const Paint& paint) {
      const float share = footprint.in_disc(from_center, dot_radius_mm);
      coat.add(paint, share);
      printed += share;
    };
    print(p - center_dot, center_radius, team);
    for (std::size_t dot = 0; dot < patterns_.dots.size(); ++dot) {
      const Vec2 center(static_cast<float>(patterns_.dots[dot].x_mm),
                        static_cast<float>(patterns_.dots[dot].y_mm));
      const bool is_covered = robot.covered_dot == static_cast<int>(dot);
      print(p - center, static_cast<float>(patterns_.dots[dot].diameter_mm) / 2,
            is_covered ? kRobotTop : colors[code->colors[dot]]);
    }
    // Dots lie inside the outline, so the rest of the top's coverage is black, even where both edges cross a
    // pixel.
    coat.add(kRobotTop, std::max(0.0F, lid - printed));
    const float above = std::max(lid, std::min(printed, 1.0F));
    coat.add(kRobotSide, std::max(0.0F, body - above));
    coat.opacity += std::max(above, body);
  };
  // If the robot is at rest, skip the pixels of its box that it cannot cover: most of them if it lies
  // diagonally in the box.
  const Vec2 along = foot.middle - top.middle;
  const float length2 = std::max(along.squaredNorm(), 1e-6F);
  const float reach_px = shapes.size() > 1 || motion != nullptr ? std::numeric_limits<float>::infinity()
                                                                : std::max(top.reach_px, foot.reach_px);
  const auto may_show = [&](int x, int y) {
    const Vec2 from_top = Vec2(static_cast<float>(x), static_cast<float>(y)) - top.middle;
    const float t = std::clamp(from_top.dot(along) / length2, 0.0F, 1.0F);
    return (from_top - t * along).squaredNorm() <= reach_px * reach_px;
  };
  paint(box, robot.height_mm, {shapes.data(), shapes.size()}, coat_of, may_show, picture, motion);
}

/// The soft shadow of a thing on the floor under ceiling lamps: strongest below the thing, and shifted
/// slightly away from the two nearest lamps.
template <class List>
void SimulatorRenderer::draw_soft_shadow(std::span<const SimulatedScene> moments, List SimulatedScene::*list,
                                         std::size_t index, const SimulatorMotion* motion, double radius_mm,
                                         double height_mm, LightPicture& picture, Boxes& boxes) const {
  const auto radius = static_cast<float>(radius_mm), soft = static_cast<float>(0.8 * height_mm);
  const auto& middle = (moments.front().*list)[index];
  // Shifts of the shadow by the two nearest lamps: the offset of the shadow of a point at half the thing's
  // height.
  std::array<Vec2, 2> away{};
  std::array<double, 2> nearest{1e300, 1e300};
  for (const Eigen::Vector3d& lamp : lamps_.places_mm()) {
    const Eigen::Vector2d from_lamp = Eigen::Vector2d(middle.x_mm, middle.y_mm) - lamp.head<2>();
    const std::size_t later = nearest[0] > nearest[1] ? 0 : 1;
    if (from_lamp.norm() >= nearest[later]) continue;
    nearest[later] = from_lamp.norm();
    away[later] = (from_lamp * 0.5 * height_mm / lamp.z()).cast<float>();
  }
  const float reach = std::max(away[0].norm(), away[1].norm()) + radius + soft;
  boost::container::static_vector<Shape, kMaxMoments> shapes;
  DrawnBox box{};
  for (const SimulatedScene& moment : moments) {
    const auto& thing = (moment.*list)[index];
    shapes.push_back({{thing.x_mm, thing.y_mm}});
    box = join(box, box_of({thing.x_mm, thing.y_mm, 0}, reach, motion));
  }
  box = in_picture(box);
  if (box.empty()) return;
  boxes.push_back(box);
  const auto coat_of = [&](const Vec2& p, const Footprint& /*footprint*/, const Shape& /*shape*/,
                           Coat& coat) {
    const auto dark = [&](const Vec2& from, float share) {
      return 1 - share * shadows_ * (1 - smooth_step(radius - 0.3F * soft, radius + soft, from.norm()));
    };
    coat.opacity += 1 - dark(p, 0.45F) * dark(p - away[0], 0.3F) * dark(p - away[1], 0.3F);
  };
  const SimulatorMotion straight =
      motion != nullptr ? SimulatorMotion{motion->x_mm_s, motion->y_mm_s, 0, motion->x_mm_s2, motion->y_mm_s2}
                        : SimulatorMotion{};
  paint(box, 0, {shapes.data(), shapes.size()}, coat_of, kEverywhere, picture,
        motion != nullptr ? &straight : nullptr);
}

/// The ball's shadow on the carpet: a darker disc on the side away from the lamp.
void SimulatorRenderer::draw_shadow(std::span<const SimulatedScene> moments, std::size_t index,
                                    const SimulatorMotion* motion, float gloss, LightPicture& picture,
                                    Boxes& boxes) const {
  const auto radius = static_cast<float>(field_.ball_radius);
  const Vec2 away = -kLampDirection.head<2>() / kLampDirection.z() * radius;
  boost::container::static_vector<Shape, kMaxMoments> shapes;
  DrawnBox box{};
  for (const SimulatedScene& moment : moments) {
    const SimulatedBall& ball = moment.balls[index];
    const Eigen::Vector2d middle = Eigen::Vector2d(ball.x_mm, ball.y_mm) + away.cast<double>();
    shapes.push_back({middle});
    box = join(box, box_of({middle.x(), middle.y(), 0}, field_.ball_radius, motion));
  }
  box = in_picture(box);
  if (box.empty()) return;
  boxes.push_back(box);
  const auto coat_of = [&](const Vec2& p, const Footprint& footprint, const Shape& /*shape*/, Coat& coat) {
    coat.opacity += 0.4F * gloss * footprint.in_disc(p, radius);
  };
  paint(box, 0, {shapes.data(), shapes.size()}, coat_of, kEverywhere, picture, motion);
}

void SimulatorRenderer::draw_ball(std::span<const SimulatedScene> moments, std::size_t index,
                                  const SimulatorMotion* motion, LightPicture& picture, Boxes& boxes) const {
  const auto radius = static_cast<float>(field_.ball_radius);
  const Eigen::Vector3d& eye = camera_.position_mm();
  Eigen::Vector3f sight = Eigen::Vector3f::Zero();  // direction from the camera
  boost::container::static_vector<Shape, kMaxMoments> shapes;
  DrawnBox box{};
  for (const SimulatedScene& moment : moments) {
    const SimulatedBall& ball = moment.balls[index];
    shapes.push_back({{ball.x_mm, ball.y_mm}});
    sight = (Eigen::Vector3d(ball.x_mm, ball.y_mm, field_.ball_radius) - eye).normalized().cast<float>();
    if (sight.z() >= 0) return;
    box = join(box, box_of({ball.x_mm, ball.y_mm, field_.ball_radius}, radius / -sight.z(), motion));
  }
  box = in_picture(box);
  if (box.empty()) return;
  boxes.push_back(box);

  const auto gloss = static_cast<float>(options_.ball_gloss);
  if (gloss > 0) draw_shadow(moments, index, motion, gloss, picture, boxes);
  const Eigen::Vector3f halfway = (kLampDirection - sight).normalized();  // mirrors the lamp into the camera
  // A ray that crosses the plane of the ball's centre at p passes the centre at distance |p - n (n p)|. The
  // ray's direction n is nearly constant over a ball.
  const auto coat_of = [&](const Vec2& p, const Footprint& footprint, const Shape& /*shape*/, Coat& coat) {
    const Eigen::Vector3f nearest = Eigen::Vector3f(p.x(), p.y(), 0) - sight * sight.head<2>().dot(p);
    const float distance = std::max(nearest.norm(), 1e-6F);
    const Vec2 outwards = nearest.head<2>() / distance;
    const float share = covered(radius - distance, outwards.dot(footprint.dx), outwards.dot(footprint.dy));
    const float depth = std::sqrt(std::max(0.0F, radius * radius - distance * distance));
    const Eigen::Vector3f normal = (nearest - sight * depth) / radius;
    // Evenly lit from above: brightest where the surface is horizontal.
    const float even = 0.7F + 0.35F * std::max(0.0F, normal.z());
    const float lamp = 0.5F + 0.6F * std::max(0.0F, normal.dot(kLampDirection));
    const float spot = gloss * std::pow(std::max(0.0F, normal.dot(halfway)), 8.0F);
    coat.add(prints_.ball(), share * (even + gloss * (lamp - even)));
    coat.add(kLampSpot, share * spot);
    coat.opacity += share;
  };
  paint(box, field_.ball_radius, {shapes.data(), shapes.size()}, coat_of, kEverywhere, picture, motion);
}

void SimulatorRenderer::draw(std::span<const SimulatedScene> moments, LightPicture& picture, Boxes& boxes,
                             const SimulatorMotions* motions) const noexcept {
  boxes.clear();
  const auto motion_of_robot = [&](std::size_t i) {
    return motions != nullptr ? &motions->robots[i] : nullptr;
  };
  const auto motion_of_ball = [&](std::size_t i) {
    return motions != nullptr ? &motions->balls[i] : nullptr;
  };
  const SimulatedScene& scene = moments.front();
  if (options_.placement == SimulatorPlacement::kScatter) {
    for (const SimulatedDistractor& distractor : scene.distractors) {
      const DrawnBox box = draw_distractor(distractor, picture);
      if (!box.empty()) boxes.push_back(box);
    }
  }
  if (shadows_ > 0) {
    for (std::size_t i = 0; i < scene.robots.size(); ++i) {
      draw_soft_shadow(moments, &SimulatedScene::robots, i, motion_of_robot(i), field_.max_robot_radius,
                       scene.robots[i].height_mm, picture, boxes);
    }
    for (std::size_t i = 0; i < scene.balls.size(); ++i) {
      draw_soft_shadow(moments, &SimulatedScene::balls, i, motion_of_ball(i), field_.ball_radius,
                       2 * field_.ball_radius, picture, boxes);
    }
  }
  // Draw distant things first: only a thing closer to the point below the camera can hide another. For discs,
  // closer means a shorter tangent.
  struct Thing {
    double tangent2_mm2;
    std::size_t index;
    bool is_robot;
  };
  boost::container::static_vector<Thing, SimulatedScene::kMaxRobots + SimulatedScene::kMaxBalls> things;
  const auto add = [&](const auto& list, double radius_mm, bool is_robot) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Eigen::Vector2d from_foot =
          Eigen::Vector2d(list[i].x_mm, list[i].y_mm) - camera_.position_mm().head<2>();
      things.push_back({from_foot.squaredNorm() - radius_mm * radius_mm, i, is_robot});
    }
  };
  add(scene.balls, field_.ball_radius, false);
  add(scene.robots, field_.max_robot_radius, true);
  std::sort(things.begin(), things.end(),
            [](const Thing& a, const Thing& b) { return a.tangent2_mm2 > b.tangent2_mm2; });
  for (const Thing& thing : things) {
    if (thing.is_robot) {
      draw_robot(moments, thing.index, motion_of_robot(thing.index), picture, boxes);
    } else {
      draw_ball(moments, thing.index, motion_of_ball(thing.index), picture, boxes);
    }
  }
}

}  // namespace sslv
