// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator_world.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string_view>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr double kFromLinesMm = 30;  // robots keep inside the field's lines

/// The angle between neighbours when `count` things of radius `radius_mm` or more from the centre must keep
/// `apart_mm`; nothing when they do not fit.
std::optional<double> least_angle(int count, double radius_mm, double apart_mm) {
  if (count < 2) return 0.0;
  if (apart_mm > 2 * radius_mm) return std::nullopt;
  const double angle = 2 * std::asin(apart_mm / (2 * radius_mm));
  if (angle * count > kTwoPi) return std::nullopt;
  return angle;
}

double normalized(double angle_rad) {
  const double angle = std::remainder(angle_rad, kTwoPi);
  return angle <= -std::numbers::pi ? angle + kTwoPi : angle;
}

template <class List>
void shuffle(List& list, SimulatorRandom& random) {
  for (std::size_t i = list.size(); i > 1; --i) std::swap(list[i - 1], list[random.bits() % i]);
}

/// For each of `robots` the side dot of it that is covered, if any.
boost::container::static_vector<std::optional<int>, SimulatedScene::kMaxRobots> covered_dots(
    std::size_t robots, int covered, SimulatorRandom& random) {
  constexpr std::uint64_t kSideDots = 4;
  boost::container::static_vector<std::optional<int>, SimulatedScene::kMaxRobots> dots(robots);
  for (std::size_t i = 0; i < std::min(robots, static_cast<std::size_t>(covered)); ++i) {
    dots[i] = static_cast<int>(random.bits() % kSideDots);
  }
  shuffle(dots, random);
  return dots;
}

/// A distractor at the field's centre.
SimulatedDistractor make_distractor(SimulatorRandom& random) {
  constexpr double kLeastMm = 15, kMostMm = 250;
  // Small ones as often as large ones.
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
  out.length_mm = kind == kStripe ? size_mm(100, kMostMm) : size_mm(kLeastMm, kMostMm);
  out.width_mm = kind == kDisc     ? out.length_mm
                 : kind == kStripe ? random.uniform(kLeastMm, 27)
                                   : size_mm(kLeastMm, kMostMm);
  const auto is_ball_sized = [](double mm) { return mm >= 28 && mm <= 65; };
  const bool is_ball_colored = out.paint == label::kOrange || out.paint == paint::kRed;
  if (is_ball_colored && is_ball_sized(out.length_mm) && is_ball_sized(out.width_mm)) {
    out.paint = paint::kPurple;
  }
  return out;
}

double reach_mm(const SimulatedDistractor& d) {
  return std::hypot(d.length_mm, d.width_mm) / 2;
}

}  // namespace

bool hides(const SimulatedRobot& robot, double robot_radius_mm, const Eigen::Vector3d& point_mm,
           const Eigen::Vector3d& eye_mm) {
  if (robot.height_mm <= point_mm.z() || robot.height_mm >= eye_mm.z()) return false;
  // The line of sight from the point to the plane of the top, in the robot's frame.
  const double share = (robot.height_mm - point_mm.z()) / (eye_mm.z() - point_mm.z());
  const Eigen::Rotation2Dd turn(-robot.orientation_rad);
  const Eigen::Vector2d from = turn * (point_mm.head<2>() - Eigen::Vector2d(robot.x_mm, robot.y_mm));
  const Eigen::Vector2d along = turn * (share * (eye_mm - point_mm).head<2>());
  // The part of it that is not in front of the front.
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
  static const auto points = [] {
    constexpr double kGoldenAngle = 2.399963229728653;
    std::array<Eigen::Vector2d, 256> out;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const double angle = kGoldenAngle * static_cast<double>(i);
      const double r = std::sqrt((static_cast<double>(i) + 0.5) / out.size());
      out[i] = r * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    return out;
  }();
  return points;
}

double SimulatedWorld::Swing::at(double t_s) const {
  return middle + reach * std::sin(kTwoPi * rate_hz * t_s + phase);
}

SimulatedWorld::SimulatedWorld(const SimulatorOptions& options, const FieldSize& field,
                               const std::array<double, 2>& robot_height_mm, const CameraModel* camera)
    : options_(options), field_(field), robot_height_mm_(robot_height_mm) {
  if (camera != nullptr) camera_ = *camera;
  for (int i = 0; i < options.robots_yellow; ++i)
    roster_.emplace_back(Team::kYellow, options.first_yellow_id + i);
  for (int i = 0; i < options.robots_blue; ++i) roster_.emplace_back(Team::kBlue, options.first_blue_id + i);

  const auto seed = static_cast<std::uint64_t>(options.seed);
  if (options.placement == SimulatorPlacement::kPaths) {
    SimulatorRandom random(seed);
    lay_paths(random);
    const auto dots = covered_dots(drivers_.size(), options.covered_dots, random);
    for (std::size_t i = 0; i < dots.size(); ++i) drivers_[i].covered_dot = dots[i];
    for (int i = 0; i < options.distractors; ++i) {
      SimulatedDistractor& one = distractors_.emplace_back(make_distractor(random));
      one.x_mm = random.uniform(-0.5, 0.5) * field.field_length;
      one.y_mm = random.uniform(-0.5, 0.5) * field.field_width;
    }
    return;
  }
  if (options.hidden_balls > 0 && !camera_) {
    throw SettingsError(
        fmt::format("hidden_balls: {} is not allowed without a camera to hide them from; expected 0",
                    options.hidden_balls));
  }
  constexpr std::int64_t kTriedSlots = 32;
  for (std::int64_t slot = 0; slot < kTriedSlots; ++slot) {
    if (const char* key = scattered_in_slot(slot).no_room_for) throw no_room(key);
  }
}

SettingsError SimulatedWorld::no_room(std::string_view key) const {
  const FieldSize& field = field_;
  const std::string on_field = fmt::format("on a field of {} x {} mm", field.field_length, field.field_width);
  if (key == "hidden_balls") {
    return SettingsError(
        fmt::format("hidden_balls: {}, each hidden by {} % from this camera, are not allowed {}; "
                    "expected fewer or less hidden ones",
                    options_.hidden_balls, 100 * options_.hidden_share, on_field));
  }
  if (key == "distractors") {
    return SettingsError(
        fmt::format("distractors: {} are not allowed {}; expected fewer", options_.distractors, on_field));
  }
  return SettingsError(fmt::format(
      "robots_yellow, robots_blue, balls: {} robots and {} balls are not allowed {}; expected fewer",
      roster_.size(), options_.balls, on_field));
}

void SimulatedWorld::lay_paths(SimulatorRandom& random) {
  const SimulatorOptions& options = options_;
  const FieldSize& field = field_;
  const auto no_room = [&] { return this->no_room("robots"); };
  const double edge_mm = field.max_robot_radius + kFromLinesMm;
  const double half_x = field.field_length / 2.0 - edge_mm, half_y = field.field_width / 2.0 - edge_mm;
  const double disc_mm = std::min(half_x, half_y);
  const double robots_apart_mm = 2 * field.max_robot_radius + kClearanceMm;
  const double balls_apart_mm = 2 * field.ball_radius + kClearanceMm;
  const double robot_to_ball_mm = field.max_robot_radius + field.ball_radius + kClearanceMm;
  const double least_pitch_mm = 2 * robot_to_ball_mm + 10;  // between two rings, with a lane for balls
  if (disc_mm < least_pitch_mm) throw no_room();
  stretch_x_ = half_x / disc_mm;
  stretch_y_ = half_y / disc_mm;

  // More robots, more rings, as far as the field is wide enough.
  const auto robots = static_cast<int>(roster_.size());
  const int wanted_rings = std::max(1, static_cast<int>(std::lround(std::sqrt(0.75 * robots))));
  const int rings = std::min(wanted_rings, static_cast<int>(disc_mm / least_pitch_mm));
  const double pitch_mm = disc_mm / rings;
  const double wobble_mm = 0.2 * (pitch_mm - least_pitch_mm);
  const auto ring_radius_mm = [&](int ring) { return (ring + 0.8) * pitch_mm; };

  // Fill the rings evenly along their length.
  std::vector<int> on_ring(static_cast<std::size_t>(rings), 0);
  for (int robot = 0; robot < robots; ++robot) {
    int best = -1;
    for (int ring = 0; ring < rings; ++ring) {
      const int count = on_ring[static_cast<std::size_t>(ring)] + 1;
      if (!least_angle(count, ring_radius_mm(ring) - wobble_mm, robots_apart_mm)) continue;
      if (best < 0 || count / ring_radius_mm(ring) <
                          (on_ring[static_cast<std::size_t>(best)] + 1) / ring_radius_mm(best)) {
        best = ring;
      }
    }
    if (best < 0) throw no_room();
    ++on_ring[static_cast<std::size_t>(best)];
  }

  auto roster = roster_;
  shuffle(roster, random);

  /// `count` things that share a turning, evenly spaced, each swinging as far as `apart_mm` leaves room for.
  const auto orbits = [&](int count, const Swing& radius, double apart_mm, double speed_mm_s) {
    const double turn_rad_s = (random.bits() % 2 == 0 ? 1 : -1) * speed_mm_s / radius.middle;
    const double start = random.angle();
    const double least = *least_angle(count, radius.middle - radius.reach, apart_mm);
    const double spare = 0.499 * (kTwoPi / std::max(count, 1) - least);
    std::vector<Orbit> out;
    for (int i = 0; i < count; ++i) {
      Orbit& orbit = out.emplace_back();
      orbit.radius_mm = {radius.middle, radius.reach, random.uniform(0.03, 0.12), random.angle()};
      // No more than 500 mm, so that swinging stays slower than driving.
      orbit.angle_rad = {start + i * kTwoPi / count, std::min(spare, 500 / radius.middle),
                         random.uniform(0.04, 0.12), random.angle()};
      orbit.turn_rad_s = turn_rad_s;
    }
    return out;
  };

  std::size_t next = 0;
  for (int ring = 0; ring < rings; ++ring) {
    const Swing radius{ring_radius_mm(ring), wobble_mm, 0, 0};
    const double speed_mm_s = random.uniform(400, 900);
    for (const Orbit& orbit :
         orbits(on_ring[static_cast<std::size_t>(ring)], radius, robots_apart_mm, speed_mm_s)) {
      const auto [team, id] = roster[next++];
      drivers_.push_back(
          {team, id, orbit, {random.angle(), 2.0, random.uniform(0.05, 0.2), random.angle()}, {}});
    }
  }

  // Lane n lies inside ring n; balls start in the middle lane.
  for (int lane = 0; lane < rings; ++lane) {
    const int offset = (lane - rings / 2 + rings) % rings;
    const int count = options.balls / rings + (offset < options.balls % rings ? 1 : 0);
    const double margin_mm = wobble_mm + robot_to_ball_mm;
    const double inner_mm = lane == 0 ? 0.15 * pitch_mm : ring_radius_mm(lane - 1) + margin_mm;
    const double outer_mm = ring_radius_mm(lane) - margin_mm;
    if (!least_angle(count, inner_mm, balls_apart_mm)) throw no_room();
    const Swing radius{(inner_mm + outer_mm) / 2, (outer_mm - inner_mm) / 2, 0, 0};
    const double speed_mm_s = random.uniform(500, 1200);
    for (const Orbit& orbit : orbits(count, radius, balls_apart_mm, speed_mm_s)) balls_.push_back(orbit);
  }
}

SimulatedWorld::Point SimulatedWorld::on_field(const Orbit& orbit, double t_s) const {
  const double radius = orbit.radius_mm.at(t_s);
  const double angle = orbit.angle_rad.at(t_s) + orbit.turn_rad_s * t_s;
  const double c = std::cos(angle), s = std::sin(angle);
  const double forward = orbit.turn_rad_s < 0 ? -1 : 1;
  return {stretch_x_ * radius * c, stretch_y_ * radius * s,
          std::atan2(forward * stretch_y_ * c, -forward * stretch_x_ * s)};
}

SimulatedScene SimulatedWorld::on_paths(double t_s) const {
  const double t = options_.speed * t_s;
  SimulatedScene scene;
  for (const Driver& driver : drivers_) {
    const Point point = on_field(driver.orbit, t);
    scene.robots.push_back({driver.team, driver.id, point.x_mm, point.y_mm,
                            normalized(point.travel_rad + driver.heading_rad.at(t)),
                            robot_height_mm_[static_cast<std::size_t>(driver.team)], driver.covered_dot});
  }
  for (const Orbit& orbit : balls_) {
    const Point point = on_field(orbit, t);
    scene.balls.push_back({point.x_mm, point.y_mm});
  }
  scene.distractors.assign(distractors_.begin(), distractors_.end());
  return scene;
}

/// Puts one thing after the other at a random place that is still free. Each keep-clear rule is looked at
/// when the later of the two comes, so the order is: what is hard to place first.
class SimulatedWorld::Scatter {
 public:
  Scatter(const SimulatedWorld& world, std::uint64_t seed)
      : options_(world.options_),
        field_(world.field_),
        robot_height_mm_(world.robot_height_mm_),
        camera_(world.camera_ ? &*world.camera_ : nullptr),
        random_(seed) {
    for (const auto& entry : world.roster_) roster_.push_back(entry);
  }

  Slot fill() {
    shuffle(roster_, random_);
    dots_ = covered_dots(roster_.size(), options_.covered_dots, random_);
    const auto robots = static_cast<int>(roster_.size());
    const int hiding = std::min(options_.hidden_balls, robots - options_.touching);
    const auto each = [&](int from, int to, int step, const char* key, const auto& placed) {
      for (int i = from; i < to; i += step) {
        if (!tried([&] { return placed(static_cast<std::size_t>(i)); })) slot_.no_room_for = key;
      }
    };
    each(0, options_.touching, 2, "robots", [&](std::size_t i) { return place_pair(i); });
    each(options_.touching, options_.touching + hiding, 1, "hidden_balls",
         [&](std::size_t i) { return place_with_hidden_ball(i); });
    each(options_.touching + hiding, robots, 1, "robots", [&](std::size_t i) { return place_robot(i); });
    each(options_.hidden_balls, options_.balls, 1, "balls", [&](std::size_t) { return place_ball(); });
    for (int i = 0; i < options_.distractors; ++i) {
      const SimulatedDistractor distractor = make_distractor(random_);
      if (!tried([&] { return place_distractor(distractor); })) slot_.no_room_for = "distractors";
    }
    return slot_;
  }

 private:
  template <class Place>
  static bool tried(const Place& place) {
    constexpr int kAttempts = 2000;  // of which all but the last of a crowd need a few
    for (int i = 0; i < kAttempts; ++i) {
      if (place()) return true;
    }
    return false;
  }

  /// Uniform over the field inside its lines, `x_mm` and `y_mm` away from them.
  Eigen::Vector2d anywhere(double x_mm, double y_mm) {
    const double half_x = std::max(0.0, field_.field_length / 2.0 - x_mm);
    const double half_y = std::max(0.0, field_.field_width / 2.0 - y_mm);
    const double x = random_.uniform(-half_x, half_x);
    return {x, random_.uniform(-half_y, half_y)};
  }

  bool inside_lines(const Eigen::Vector2d& place, double radius_mm) const {
    return std::abs(place.x()) + radius_mm <= field_.field_length / 2.0 &&
           std::abs(place.y()) + radius_mm <= field_.field_width / 2.0;
  }

  template <class Things, class ReachOf>
  static bool clear_of(const Things& things, const Eigen::Vector2d& place, const ReachOf& reach_of) {
    return std::all_of(things.begin(), things.end(), [&](const auto& thing) {
      return (Eigen::Vector2d(thing.x_mm, thing.y_mm) - place).norm() >= reach_of(thing);
    });
  }

  /// No closer than the clearance to robots; free of balls, and between none of them and the camera. While
  /// robots are placed, there are hidden balls only.
  bool robot_fits(std::size_t index, const Eigen::Vector2d& place) const {
    return inside_lines(place, radius_mm_) &&
           clear_of(slot_.scene.robots, place,
                    [&](const SimulatedRobot&) { return 2 * radius_mm_ + kClearanceMm; }) &&
           clear_of(slot_.scene.balls, place,
                    [&](const SimulatedBall&) { return radius_mm_ + ball_mm_ + kBallClearanceMm; }) &&
           std::none_of(slot_.scene.balls.begin(), slot_.scene.balls.end(), [&](const SimulatedBall& ball) {
             return comes_between(place, height_mm(index), {ball.x_mm, ball.y_mm});
           });
  }

  bool ball_fits(const Eigen::Vector2d& place) const {
    return inside_lines(place, ball_mm_) &&
           clear_of(slot_.scene.robots, place,
                    [&](const SimulatedRobot&) { return radius_mm_ + ball_mm_ + kBallClearanceMm; }) &&
           clear_of(slot_.scene.balls, place,
                    [&](const SimulatedBall&) { return 2 * ball_mm_ + kBallClearanceMm; });
  }

  /// Whether a robot could hide some of a ball.
  bool comes_between(const Eigen::Vector2d& robot, double height_mm, const Eigen::Vector2d& ball) const {
    const Eigen::Vector2d seen_through = ball + sight_share(height_mm) * (foot() - ball);
    const Eigen::Vector2d along = seen_through - ball;
    const double t = std::clamp((robot - ball).dot(along) / std::max(along.squaredNorm(), 1e-9), 0.0, 1.0);
    return (ball + t * along - robot).norm() < radius_mm_ + ball_mm_;
  }

  Eigen::Vector2d foot() const { return camera_->position_mm().head<2>(); }
  double height_mm(std::size_t index) const {
    return robot_height_mm_[static_cast<std::size_t>(roster_[index].first)];
  }
  /// How far up the line of sight from a ball to the camera the plane of a top lies.
  double sight_share(double height_mm) const {
    return (height_mm - ball_mm_) / (camera_->position_mm().z() - ball_mm_);
  }

  SimulatedRobot robot(std::size_t index, const Eigen::Vector2d& place) {
    const auto [team, id] = roster_[index];
    return {team, id, place.x(), place.y(), normalized(random_.angle()), height_mm(index), dots_[index]};
  }

  Motion motion() {
    constexpr double kSpeedMmS = 2000, kTurnRadS = 3;
    const double direction = random_.angle(), speed = options_.speed * kSpeedMmS;
    return {speed * std::cos(direction), speed * std::sin(direction),
            options_.speed * random_.uniform(-kTurnRadS, kTurnRadS)};
  }

  void add(const SimulatedRobot& robot, const Motion& motion) {
    slot_.scene.robots.push_back(robot);
    slot_.robot_motion.push_back(motion);
  }
  void add_ball(const Eigen::Vector2d& place, const Motion& motion) {
    slot_.scene.balls.push_back({place.x(), place.y()});
    slot_.ball_motion.push_back(motion);
  }

  bool place_robot(std::size_t index) {
    const Eigen::Vector2d place = anywhere(radius_mm_, radius_mm_);
    if (!robot_fits(index, place)) return false;
    add(robot(index, place), motion());
    return true;
  }

  /// The two move together.
  bool place_pair(std::size_t first) {
    const double angle = random_.angle();
    const Eigen::Vector2d half =
        (radius_mm_ + options_.touching_gap_mm / 2) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d middle = anywhere(radius_mm_ + std::abs(half.x()), radius_mm_ + std::abs(half.y()));
    if (!robot_fits(first, middle - half) || !robot_fits(first + 1, middle + half)) return false;
    const Motion moving = motion();
    add(robot(first, middle - half), moving);
    add(robot(first + 1, middle + half), moving);
    return true;
  }

  /// The ball lies on the robot's far side and moves with it.
  bool place_with_hidden_ball(std::size_t index) {
    const Eigen::Vector2d place = anywhere(radius_mm_, radius_mm_);
    if (!robot_fits(index, place)) return false;
    const SimulatedRobot hiding = robot(index, place);
    const auto ball = ball_behind(hiding);
    if (!ball || !ball_fits(*ball) || !wholly_in_picture(*ball)) return false;
    const bool others_between =
        std::any_of(slot_.scene.robots.begin(), slot_.scene.robots.end(), [&](const SimulatedRobot& other) {
          return comes_between({other.x_mm, other.y_mm}, other.height_mm, *ball);
        });
    const auto other_between_balls =
        std::any_of(slot_.scene.balls.begin(), slot_.scene.balls.end(), [&](const SimulatedBall& other) {
          return comes_between(place, hiding.height_mm, {other.x_mm, other.y_mm});
        });
    if (others_between || other_between_balls) return false;
    const Motion moving = motion();
    add(hiding, moving);
    add_ball(*ball, moving);
    return true;
  }

  /// Where a ball is hidden by the wanted share, straight away from the camera's foot; nothing when the
  /// camera looks too steeply.
  std::optional<Eigen::Vector2d> ball_behind(const SimulatedRobot& robot) const {
    if (robot.height_mm <= ball_mm_ || robot.height_mm >= camera_->position_mm().z()) return std::nullopt;
    const Eigen::Vector2d center(robot.x_mm, robot.y_mm);
    const double from_foot_mm = (center - foot()).norm();
    if (from_foot_mm < 1) return std::nullopt;
    const Eigen::Vector2d outwards = (center - foot()) / from_foot_mm;
    const auto hidden_share = [&](double distance_mm) {
      const Eigen::Vector2d ball = center + distance_mm * outwards;
      std::size_t hidden = 0;
      for (const Eigen::Vector2d& point : points_of_disc()) {
        const Eigen::Vector2d at = ball + ball_mm_ * point;
        hidden += hides(robot, radius_mm_, {at.x(), at.y(), ball_mm_}, camera_->position_mm());
      }
      return static_cast<double>(hidden) / static_cast<double>(points_of_disc().size());
    };
    constexpr double kApartMm = 1;
    const double share = sight_share(robot.height_mm);
    double near_mm = radius_mm_ + ball_mm_ + kApartMm;
    double far_mm = (radius_mm_ + share * from_foot_mm) / (1 - share) + ball_mm_ + kApartMm;
    if (far_mm <= near_mm || hidden_share(near_mm) < options_.hidden_share) return std::nullopt;
    while (far_mm - near_mm > 0.05) {
      const double middle_mm = (near_mm + far_mm) / 2;
      (hidden_share(middle_mm) > options_.hidden_share ? near_mm : far_mm) = middle_mm;
    }
    return center + far_mm * outwards;
  }

  bool wholly_in_picture(const Eigen::Vector2d& ball) const {
    constexpr int kPoints = 8;
    for (int i = 0; i < kPoints; ++i) {
      const double angle = i * kTwoPi / kPoints;
      // A little more than the ball, as a polygon's corners stand for the whole rim.
      const Eigen::Vector2d rim = ball + 1.2 * ball_mm_ * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const auto pixel = camera_->project({rim.x(), rim.y(), ball_mm_});
      if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > options_.width - 1 ||
          pixel->y() > options_.height - 1) {
        return false;
      }
    }
    return true;
  }

  bool place_ball() {
    const Eigen::Vector2d place = anywhere(ball_mm_, ball_mm_);
    if (!ball_fits(place)) return false;
    add_ball(place, motion());
    return true;
  }

  bool place_distractor(SimulatedDistractor distractor) {
    const double reach = reach_mm(distractor);
    const Eigen::Vector2d place = anywhere(reach, reach);
    const bool fits =
        clear_of(slot_.scene.balls, place,
                 [&](const SimulatedBall&) { return reach + ball_mm_ + kDistractorToBallMm; }) &&
        clear_of(slot_.scene.distractors, place, [&](const SimulatedDistractor& other) {
          return reach + reach_mm(other) + kBetweenDistractorsMm;
        });
    if (!fits) return false;
    distractor.x_mm = place.x();
    distractor.y_mm = place.y();
    slot_.scene.distractors.push_back(distractor);
    return true;
  }

  const SimulatorOptions& options_;
  const FieldSize& field_;
  const std::array<double, 2>& robot_height_mm_;
  const CameraModel* camera_;
  SimulatorRandom random_;
  const double radius_mm_ = field_.max_robot_radius, ball_mm_ = field_.ball_radius;
  boost::container::static_vector<std::pair<Team, int>, SimulatedScene::kMaxRobots> roster_;
  boost::container::static_vector<std::optional<int>, SimulatedScene::kMaxRobots> dots_;
  Slot slot_;
};

SimulatedWorld::Slot SimulatedWorld::scattered_in_slot(std::int64_t slot) const {
  const std::uint64_t seed = scatter(static_cast<std::uint64_t>(options_.seed));
  return Scatter(*this, scatter(seed + static_cast<std::uint64_t>(slot))).fill();
}

SimulatedWorld::Slot SimulatedWorld::scattered(double t_s) const {
  constexpr double kDefaultRateHz = 60;
  const double rate_hz = options_.frame_rate_hz > 0 ? options_.frame_rate_hz : kDefaultRateHz;
  return scattered_in_slot(std::llround(t_s * rate_hz));
}

SimulatedScene SimulatedWorld::at(double t_s) const {
  return options_.placement == SimulatorPlacement::kPaths ? on_paths(t_s) : scattered(t_s).scene;
}

void SimulatedWorld::expose(double t_s, double exposure_s, std::span<SimulatedScene> moments) const {
  const auto offset_s = [&](std::size_t i) {
    return ((static_cast<double>(i) + 0.5) / static_cast<double>(moments.size()) - 0.5) * exposure_s;
  };
  if (options_.placement == SimulatorPlacement::kPaths) {
    for (std::size_t i = 0; i < moments.size(); ++i) moments[i] = on_paths(t_s + offset_s(i));
    return;
  }
  const Slot slot = scattered(t_s);
  for (std::size_t i = 0; i < moments.size(); ++i) {
    moments[i] = slot.scene;
    const double dt_s = offset_s(i);
    for (std::size_t n = 0; n < slot.robot_motion.size(); ++n) {
      SimulatedRobot& robot = moments[i].robots[n];
      robot.x_mm += slot.robot_motion[n].x_mm_s * dt_s;
      robot.y_mm += slot.robot_motion[n].y_mm_s * dt_s;
      robot.orientation_rad = normalized(robot.orientation_rad + slot.robot_motion[n].turn_rad_s * dt_s);
    }
    for (std::size_t n = 0; n < slot.ball_motion.size(); ++n) {
      moments[i].balls[n].x_mm += slot.ball_motion[n].x_mm_s * dt_s;
      moments[i].balls[n].y_mm += slot.ball_motion[n].y_mm_s * dt_s;
    }
  }
}

}  // namespace sslv
