// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sslv {

SimulatedScene moved(const SimulatedScene& scene, const SimulatorMotions& motions, double dt_s) {
  SimulatedScene out = scene;
  for (std::size_t i = 0; i < motions.robots.size(); ++i) {
    SimulatedRobot& robot = out.robots[i];
    const Eigen::Vector2d way_mm = motions.robots[i].way_mm(dt_s);
    robot.x_mm += way_mm.x(), robot.y_mm += way_mm.y();
    robot.orientation_rad = normalized(robot.orientation_rad + motions.robots[i].turn_rad(dt_s));
  }
  for (std::size_t i = 0; i < motions.balls.size(); ++i) {
    const Eigen::Vector2d way_mm = motions.balls[i].way_mm(dt_s);
    out.balls[i].x_mm += way_mm.x(), out.balls[i].y_mm += way_mm.y();
  }
  return out;
}

bool hides(const SimulatedRobot& robot, double robot_radius_mm, const Eigen::Vector3d& point_mm,
           const Eigen::Vector3d& eye_mm) {
  if (robot.height_mm <= point_mm.z() || robot.height_mm >= eye_mm.z()) return false;
  // The line of sight from the point to the plane of the top, in the robot's frame.
  const double share = (robot.height_mm - point_mm.z()) / (eye_mm.z() - point_mm.z());
  const Eigen::Rotation2Dd turn(-robot.orientation_rad);
  const Eigen::Vector2d from = turn * (point_mm.head<2>() - Eigen::Vector2d(robot.x_mm, robot.y_mm));
  const Eigen::Vector2d along = turn * (share * (eye_mm - point_mm).head<2>());
  // The section of that line that is not beyond the flat front.
  const double front_mm = robot_radius_mm * kRobotFrontPerRadius;
  double begin = 0, end = 1;
  if (along.x() == 0) {
    if (from.x() > front_mm) return false;
  } else {
    const double crossing = (front_mm - from.x()) / along.x();
    (along.x() > 0 ? end : begin) = along.x() > 0 ? std::min(end, crossing) : std::max(begin, crossing);
  }
  if (begin > end) return false;
  const double nearest = std::clamp(-from.dot(along) / std::max(along.squaredNorm(), 1e-12), begin, end);
  return (from + nearest * along).norm() <= robot_radius_mm;
}

const std::array<Eigen::Vector2d, 256>& points_of_disc() {
  static const auto kPoints = [] {
    constexpr double kGoldenAngle = 2.399963229728653;
    std::array<Eigen::Vector2d, 256> out;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double angle = kGoldenAngle * static_cast<double>(i);
      const double r = std::sqrt((static_cast<double>(i) + 0.5) / out.size());
      out[i] = r * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    return out;
  }();
  return kPoints;
}

SimulatedRoster roster_of(const SimulatorOptions& options) {
  SimulatedRoster roster;
  const auto add = [&](Team team, int robots, int first_id) {
    for (int i = 0; i < robots; ++i) roster.emplace_back(team, i <= options.twins ? first_id : first_id + i);
  };
  add(Team::kYellow, options.robots_yellow, options.first_yellow_id);
  add(Team::kBlue, options.robots_blue, options.first_blue_id);
  return roster;
}

std::int64_t picture_number(const SimulatorOptions& options, double t_s) {
  constexpr double kDefaultRateHz = 60;
  return std::llround(t_s * (options.frame_rate_hz > 0 ? options.frame_rate_hz : kDefaultRateHz));
}

PerRobot<std::optional<int>> choose_covered_dots(std::size_t robots, int covered, SimulatorRandom& random) {
  constexpr std::uint64_t kSideDots = 4;
  PerRobot<std::optional<int>> dots(robots);
  for (std::size_t i = 0; i < std::min(robots, static_cast<std::size_t>(covered)); ++i) {
    dots[i] = static_cast<int>(random.bits() % kSideDots);
  }
  shuffle(dots, random);
  return dots;
}

SimulatedDistractor make_distractor(SimulatorRandom& random) {
  constexpr double kMinMm = 15, kMaxMm = 250;
  // Log-uniform: small sizes are as frequent as large ones.
  const auto size_mm = [&](double least, double most) {
    return std::min(most, least * std::exp(random.uniform(0, std::log(most / least))));
  };
  enum Kind { kDisc, kEllipse, kRectangle, kTriangle, kStripe, kKinds };
  using Shape = SimulatedDistractor::Shape;
  constexpr std::array<Shape, kKinds> kShapes{Shape::kEllipse, Shape::kEllipse, Shape::kRectangle,
                                              Shape::kTriangle, Shape::kRectangle};
  const auto kind = random.bits() % kKinds;
  SimulatedDistractor out{};
  out.shape = kShapes[kind];
  out.paint = static_cast<std::uint8_t>(label::kOrange + random.bits() % (paint::kCount - label::kOrange));
  out.turn_rad = random.angle();
  out.length_mm = kind == kStripe ? size_mm(100, kMaxMm) : size_mm(kMinMm, kMaxMm);
  out.width_mm = kind == kDisc     ? out.length_mm
                 : kind == kStripe ? random.uniform(kMinMm, 27)
                                   : size_mm(kMinMm, kMaxMm);
  const auto is_ball_sized = [](double mm) { return mm >= 28 && mm <= 65; };
  const bool is_ball_colored = out.paint == label::kOrange || out.paint == paint::kRed;
  if (is_ball_colored && is_ball_sized(out.length_mm) && is_ball_sized(out.width_mm)) {
    out.paint = paint::kPurple;
  }
  return out;
}

double normalized(double angle_rad) {
  constexpr double kFullTurn = 2 * std::numbers::pi;
  const double angle = std::remainder(angle_rad, kFullTurn);
  return angle <= -std::numbers::pi ? angle + kFullTurn : angle;
}

SettingsError no_room(std::string_view key, const SimulatorOptions& options, const FieldSize& field) {
  const std::string on_field = fmt::format("on a field of {} x {} mm", field.field_length, field.field_width);
  if (key == "hidden_balls") {
    return SettingsError(
        fmt::format("hidden_balls: {}, each hidden by {} % from this camera, are not allowed {}; expected "
                    "fewer, or a smaller hidden_share",
                    options.hidden_balls, 100 * options.hidden_share, on_field));
  }
  if (key == "distractors") {
    return SettingsError(
        fmt::format("distractors: {} are not allowed {}; expected fewer", options.distractors, on_field));
  }
  return SettingsError(fmt::format(
      "robots_yellow, robots_blue, balls: {} robots and {} balls are not allowed {}; expected fewer",
      options.robots_yellow + options.robots_blue, options.balls, on_field));
}

}  // namespace sslv
