// SPDX-License-Identifier: Apache-2.0
#include "capture/simulator/simulator_scatter.h"

#include "capture/simulator/simulator_prints.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kTurnRad = 2 * std::numbers::pi;

double reach_mm(const SimulatedDistractor& d) {
  return std::hypot(d.length_mm, d.width_mm) / 2;
}

/// Places things one by one at random free positions. Each gap is checked when the later of the two things is
/// placed, so things that are hard to place must be placed first.
class Filler {
 public:
  Filler(const SimulatorOptions& options, const FieldSize& field,
         const std::array<double, 2>& robot_height_mm, const CameraModel* camera, std::uint64_t seed)
      : options_(options),
        field_(field),
        robot_height_mm_(robot_height_mm),
        camera_(camera),
        random_(seed),
        roster_(roster_of(options)) {}

  SimulatorSlot fill() {
    shuffle(roster_, random_);
    dots_ = choose_covered_dots(roster_.size(), options_.covered_dots, random_);
    const auto robots = static_cast<int>(roster_.size());
    const int hiding = std::min(options_.hidden_balls, robots - options_.touching);
    const auto each = [&](int from, int to, int step, const char* key, const auto& placed) {
      for (int i = from; i < to; i += step) {
        if (!try_often([&] { return placed(static_cast<std::size_t>(i)); })) slot_.no_room_for = key;
      }
    };
    each(0, options_.touching, 2, "robots", [&](std::size_t i) { return place_pair(i); });
    each(options_.touching, options_.touching + hiding, 1, "hidden_balls",
         [&](std::size_t i) { return place_with_hidden_ball(i); });
    each(options_.touching + hiding, robots, 1, "robots", [&](std::size_t i) { return place_robot(i); });
    each(options_.hidden_balls, options_.balls, 1, "balls", [&](std::size_t) { return place_ball(); });
    for (int i = 0; i < options_.distractors; ++i) {
      const SimulatedDistractor distractor = make_distractor(random_);
      if (!try_often([&] { return place_distractor(distractor); })) slot_.no_room_for = "distractors";
    }
    return slot_;
  }

 private:
  template <class Place>
  static bool try_often(const Place& place) {
    constexpr int kAttempts = 2000;  // only the last things on a crowded field need more than a few
    for (int i = 0; i < kAttempts; ++i) {
      if (place()) return true;
    }
    return false;
  }

  /// Uniform over the field inside its lines, at least `x_mm` and `y_mm` away from them.
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

  /// Whether the robot keeps its distance from robots and balls, and is not between a ball and the camera.
  /// While robots are being placed, the only balls are balls hidden by robots.
  bool robot_fits(std::size_t index, const Eigen::Vector2d& place) const {
    return inside_lines(place, radius_mm_) &&
           clear_of(slot_.scene.robots, place,
                    [&](const SimulatedRobot&) { return 2 * radius_mm_ + kSimulatorClearanceMm; }) &&
           clear_of(slot_.scene.balls, place,
                    [&](const SimulatedBall&) {
                      return radius_mm_ + ball_mm_ + SimulatorScatter::kBallClearanceMm;
                    }) &&
           std::none_of(slot_.scene.balls.begin(), slot_.scene.balls.end(), [&](const SimulatedBall& ball) {
             return comes_between(place, height_mm(index), {ball.x_mm, ball.y_mm});
           });
  }

  bool ball_fits(const Eigen::Vector2d& place) const {
    return inside_lines(place, ball_mm_) &&
           clear_of(slot_.scene.robots, place,
                    [&](const SimulatedRobot&) {
                      return radius_mm_ + ball_mm_ + SimulatorScatter::kBallClearanceMm;
                    }) &&
           clear_of(slot_.scene.balls, place,
                    [&](const SimulatedBall&) { return 2 * ball_mm_ + SimulatorScatter::kBallClearanceMm; });
  }

  /// Whether a robot could partly hide a ball.
  bool comes_between(const Eigen::Vector2d& robot, double height_mm, const Eigen::Vector2d& ball) const {
    const Eigen::Vector2d seen_through = ball + sight_share(height_mm) * (foot() - ball);
    const Eigen::Vector2d along = seen_through - ball;
    const double t = std::clamp((robot - ball).dot(along) / std::max(along.squaredNorm(), 1e-9), 0.0, 1.0);
    return (ball + t * along - robot).norm() < radius_mm_ + ball_mm_;
  }

  Eigen::Vector2d foot() const { return camera_->position_mm().head<2>(); }
  double height_mm(std::size_t index) const {
    const auto [team, id] = roster_[index];
    return print_height_mm(options_.hall, team, id, robot_height_mm_[static_cast<std::size_t>(team)]);
  }
  /// Fraction of the line of sight from a ball to the camera at which the line crosses the plane of a robot's
  /// top.
  double sight_share(double height_mm) const {
    return (height_mm - ball_mm_) / (camera_->position_mm().z() - ball_mm_);
  }

  SimulatedRobot robot(std::size_t index, const Eigen::Vector2d& place) {
    const auto [team, id] = roster_[index];
    return {team, id, place.x(), place.y(), normalized(random_.angle()), height_mm(index), dots_[index]};
  }

  SimulatorMotion motion() {
    constexpr double kSpeedMmS = 2000, kTurnRadS = 3;
    const double direction = random_.angle(), speed = options_.speed * kSpeedMmS;
    return {speed * std::cos(direction), speed * std::sin(direction),
            options_.speed * random_.uniform(-kTurnRadS, kTurnRadS)};
  }

  void add(const SimulatedRobot& robot, const SimulatorMotion& motion) {
    slot_.scene.robots.push_back(robot);
    slot_.robot_motion.push_back(motion);
  }
  void add_ball(const Eigen::Vector2d& place, const SimulatorMotion& motion) {
    slot_.scene.balls.push_back({place.x(), place.y()});
    slot_.ball_motion.push_back(motion);
  }

  bool place_robot(std::size_t index) {
    const Eigen::Vector2d place = anywhere(radius_mm_, radius_mm_);
    if (!robot_fits(index, place)) return false;
    add(robot(index, place), motion());
    return true;
  }

  /// The two robots move together.
  bool place_pair(std::size_t first) {
    const double angle = random_.angle();
    const Eigen::Vector2d half =
        (radius_mm_ + options_.touching_gap_mm / 2) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d middle = anywhere(radius_mm_ + std::abs(half.x()), radius_mm_ + std::abs(half.y()));
    if (!robot_fits(first, middle - half) || !robot_fits(first + 1, middle + half)) return false;
    const SimulatorMotion moving = motion();
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
    const SimulatorMotion moving = motion();
    add(hiding, moving);
    add_ball(*ball, moving);
    return true;
  }

  /// The position of a ball behind the robot, as seen from the point below the camera, at which the wanted
  /// fraction of the ball is hidden; nothing if the camera looks down too steeply.
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
      const double angle = i * kTurnRad / kPoints;
      // Slightly larger than the ball: the polygon's corners represent the whole rim.
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
    const bool fits = clear_of(slot_.scene.balls, place,
                               [&](const SimulatedBall&) {
                                 return reach + ball_mm_ + SimulatorScatter::kDistractorToBallMm;
                               }) &&
                      clear_of(slot_.scene.distractors, place, [&](const SimulatedDistractor& other) {
                        return reach + reach_mm(other) + SimulatorScatter::kBetweenDistractorsMm;
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
  SimulatedRoster roster_;
  PerRobot<std::optional<int>> dots_;
  SimulatorSlot slot_;
};

}  // namespace

SimulatedScene SimulatorSlot::at(double dt_s) const {
  SimulatedScene out = scene;
  for (std::size_t i = 0; i < robot_motion.size(); ++i) {
    SimulatedRobot& robot = out.robots[i];
    robot.x_mm += robot_motion[i].x_mm_s * dt_s;
    robot.y_mm += robot_motion[i].y_mm_s * dt_s;
    robot.orientation_rad = normalized(robot.orientation_rad + robot_motion[i].turn_rad_s * dt_s);
  }
  for (std::size_t i = 0; i < ball_motion.size(); ++i) {
    out.balls[i].x_mm += ball_motion[i].x_mm_s * dt_s;
    out.balls[i].y_mm += ball_motion[i].y_mm_s * dt_s;
  }
  return out;
}

SimulatorScatter::SimulatorScatter(const SimulatorOptions& options, const FieldSize& field,
                                   const std::array<double, 2>& robot_height_mm,
                                   const std::optional<CameraModel>& camera)
    : options_(options), field_(field), robot_height_mm_(robot_height_mm), camera_(camera) {
  options_.hall = resolved(options.hall);
  if (options.hidden_balls > 0 && !camera) {
    throw SettingsError(
        fmt::format("hidden_balls: {} is not allowed without a camera to hide them from; expected 0",
                    options.hidden_balls));
  }
  constexpr std::int64_t kTriedSlots = 32;
  for (std::int64_t slot = 0; slot < kTriedSlots; ++slot) {
    if (const char* key = fill(slot).no_room_for) throw no_room(key, options_, field_);
  }
}

SimulatorSlot SimulatorScatter::slot_at(double t_s) const {
  return fill(picture_number(options_, t_s));
}

SimulatorSlot SimulatorScatter::fill(std::int64_t slot) const {
  const std::uint64_t seed = scatter(static_cast<std::uint64_t>(options_.seed));
  return Filler(options_, field_, robot_height_mm_, camera_ ? &*camera_ : nullptr,
                scatter(seed + static_cast<std::uint64_t>(slot)))
      .fill();
}

}  // namespace sslv
