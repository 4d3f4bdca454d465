// SPDX-License-Identifier: Apache-2.0
#include "world.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <string_view>

namespace sslv::worlds {

using Eigen::Vector2d, Eigen::Vector3d;

namespace {

constexpr double kStep_s = 1e-3;
constexpr double kPi = std::numbers::pi;
/// Distance from a robot's centre to a ball that touches it.
constexpr double kTouchMm = 90 + World::kBallRadiusMm;
/// Distance of a held ball, at the robot's flat front.
constexpr double kHeldMm = 100;

Vector2d along(double angle_rad) {
  return {std::cos(angle_rad), std::sin(angle_rad)};
}
Vector2d left_of(const Vector2d& v) {
  return {-v.y(), v.x()};
}
Vector2d unit(const Vector2d& v) {
  const double length = v.norm();
  return length > 1e-9 ? Vector2d(v / length) : Vector2d(0, 0);
}
double wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2 * kPi);
}

/// A robot's current intention and acceleration.
struct Driver {
  Vector2d target_mm{0, 0};
  double until_s = 0, speed_mm_s = 2000, heading_rad = 0, spin_rad_s = 0;
  enum class Mode { kDrive, kStand, kSpin } mode = Mode::kDrive;
  Vector2d acceleration{0, 0};
  double turn_acceleration = 0, last_swerve_s = -1;
  std::deque<Vector2d> accelerations;  // over the last 60 ms
};

/// A ball that is not held.
struct FreeBall {
  bool is_rolling = true, is_flying = false;
  int hops = 0;
  double slid_from_mm_s = 0;  // speed at the start of sliding
  // A kick takes a few milliseconds.
  double ramp_s = 0;
  Vector3d ramp_to{0, 0, 0};
};

class Play {
 public:
  Play(const WorldOptions& options, halls::Chance& chance) : options_(options), chance_(chance) {
    slide_mm_s2_ = chance_.uniform(3000, 4000);
    roll_mm_s2_ = chance_.uniform(260, 400);
    const auto count = static_cast<std::size_t>(options_.robots);
    drivers_.resize(count);
    robots_.resize(count);
    swerves.resize(count);
    collisions.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      robots_[i].place_mm = anywhere();
      robots_[i].angle_rad = chance_.uniform(-kPi, kPi);
      drivers_[i].target_mm = robots_[i].place_mm;
    }
    ball_.place_mm = {0, 0, World::kBallRadiusMm};
  }

  void step(double t_s) {
    for (int i = 0; i < options_.robots; ++i) drive(i, t_s);
    if (options_.robots_collide) collide(t_s);
    ball_.is_held = holder_ >= 0;
    if (holder_ >= 0) {
      hold(t_s);
    } else if (free_.ramp_s > 0) {
      accelerate_ball();
    } else {
      move_ball(t_s);
    }
    if (holder_ < 0 && t_s >= choose_again_s_) choose_chaser(t_s);
  }

  double slides_mm_s2() const { return slide_mm_s2_; }
  double rolls_mm_s2() const { return roll_mm_s2_; }
  const std::vector<RobotTruth>& robots() const { return robots_; }
  const BallTruth& ball() const { return ball_; }

  std::vector<KickTruth> kicks;
  std::vector<std::pair<double, BallTurn>> turns;
  std::vector<std::vector<double>> swerves, collisions;

 private:
  Vector2d anywhere() { return {chance_.uniform(-5500, 5500), chance_.uniform(-4200, 4200)}; }
  RobotTruth& at(int i) { return robots_[static_cast<std::size_t>(i)]; }
  Vector2d ball_on_floor() const { return ball_.place_mm.head<2>(); }
  Vector2d ball_velocity() const { return ball_.velocity_mm_s.head<2>(); }

  void drive(int i, double t_s) {
    Driver& driver = drivers_[static_cast<std::size_t>(i)];
    RobotTruth& robot = at(i);
    if (t_s >= driver.until_s) {
      const double what = chance_.uniform(0, 1);
      driver.mode = what < 0.15  ? Driver::Mode::kStand
                    : what < 0.3 ? Driver::Mode::kSpin
                                 : Driver::Mode::kDrive;
      driver.until_s = t_s + chance_.uniform(0.4, 2.2);
      driver.target_mm = anywhere();
      if (options_.robots_collide && chance_.happens(0.5))
        driver.target_mm = at(chance_.whole(0, options_.robots - 1)).place_mm;
      driver.speed_mm_s = chance_.uniform(1500, 4000);
      driver.heading_rad = chance_.uniform(-kPi, kPi);
      driver.spin_rad_s = chance_.sign() * chance_.uniform(5, 10);
    }
    Vector2d target = driver.target_mm;
    double speed = driver.speed_mm_s, heading = driver.heading_rad;
    auto mode = options_.robots_stand ? Driver::Mode::kStand : driver.mode;
    const bool holds = i == holder_;
    if (i == chaser_ && holder_ < 0 && t_s - last_kick_s_ > 0.25) {
      const Vector2d to_ball = ball_on_floor() - robot.place_mm;
      target = ball_on_floor() + 0.25 * ball_velocity();
      speed = 3500;
      mode = Driver::Mode::kDrive;
      heading = std::atan2(to_ball.y(), to_ball.x());
    }
    if (holds) {
      mode = Driver::Mode::kDrive;
      speed = std::min(speed, 1800.0);
    }
    Vector2d wanted(0, 0);
    if (mode != Driver::Mode::kStand) {
      const Vector2d way = target - robot.place_mm;
      wanted = unit(way) * std::min(speed, std::sqrt(2 * 3000 * way.norm()));
    }
    Vector2d acceleration = (wanted - robot.velocity_mm_s) / 0.04;
    constexpr double kMax = 4000;
    if (acceleration.norm() > kMax) acceleration *= kMax / acceleration.norm();
    driver.acceleration += (acceleration - driver.acceleration) * (kStep_s / 0.02);
    robot.velocity_mm_s += driver.acceleration * kStep_s;
    robot.place_mm += robot.velocity_mm_s * kStep_s;

    const double fastest = holds ? 3 : 10;
    const double turn = mode == Driver::Mode::kSpin && !holds
                            ? driver.spin_rad_s
                            : std::clamp(wrapped(heading - robot.angle_rad) * 8, -fastest, fastest);
    const double turn_faster =
        options_.robots_stand ? 0 : std::clamp((turn - robot.turn_rad_s) / 0.03, -60.0, 60.0);
    driver.turn_acceleration += (turn_faster - driver.turn_acceleration) * (kStep_s / 0.01);
    robot.turn_rad_s += driver.turn_acceleration * kStep_s;
    robot.angle_rad = wrapped(robot.angle_rad + robot.turn_rad_s * kStep_s);

    driver.accelerations.push_back(driver.acceleration);
    if (driver.accelerations.size() > 60) driver.accelerations.pop_front();
    if (driver.accelerations.size() == 60 &&
        (driver.acceleration - driver.accelerations.front()).norm() > 5000 &&
        t_s - driver.last_swerve_s > 0.25) {
      driver.last_swerve_s = t_s;
      swerves[static_cast<std::size_t>(i)].push_back(t_s - 0.025);
    }
  }

  /// Touching robots repel each other, as almost inelastic discs.
  void collide(double t_s) {
    constexpr double kDiameterMm = 180, kSpringsBack = 0.2, kPush_mm_s = 300, kNext_s = 0.3;
    for (int i = 0; i < options_.robots; ++i) {
      for (int j = 0; j < i; ++j) {
        RobotTruth &a = at(i), &b = at(j);
        const Vector2d apart = b.place_mm - a.place_mm;
        if (apart.norm() >= kDiameterMm) continue;
        const Vector2d normal = unit(apart);
        const double into = (a.velocity_mm_s - b.velocity_mm_s).dot(normal);
        const double deep = kDiameterMm - apart.norm();
        a.place_mm -= normal * deep / 2;
        b.place_mm += normal * deep / 2;
        if (into <= 0) continue;
        a.velocity_mm_s -= normal * into * (1 + kSpringsBack) / 2;
        b.velocity_mm_s += normal * into * (1 + kSpringsBack) / 2;
        if (into < kPush_mm_s) continue;
        for (const int one : {i, j}) {
          auto& times_s = collisions[static_cast<std::size_t>(one)];
          if (times_s.empty() || t_s - times_s.back() > kNext_s) times_s.push_back(t_s);
        }
      }
    }
  }

  void hold(double t_s) {
    const RobotTruth& robot = at(holder_);
    const Vector2d ahead = along(robot.angle_rad), side = left_of(ahead);
    const double wobble = 2 * std::sin(t_s * 2 * kPi * 13);  // the dribbler's
    const Vector2d place = robot.place_mm + ahead * (kHeldMm + 0.5 * wobble) + side * wobble;
    const Vector2d velocity = robot.velocity_mm_s + side * (kHeldMm * robot.turn_rad_s);
    ball_.place_mm << place, World::kBallRadiusMm;
    ball_.velocity_mm_s << velocity, 0;
    if (t_s < hold_until_s_) return;
    const bool is_chip = options_.only_chips || chance_.happens(0.3);
    const double speed = is_chip ? chance_.uniform(2500, 6300) : chance_.uniform(1200, 6500);
    const int kicker = holder_;
    kick(t_s, kicker, speed, robot.angle_rad + 0.03 * chance_.normal(), is_chip);
  }

  void kick(double t_s, int kicker, double speed, double angle_rad, bool is_chip) {
    KickTruth kick;
    kick.t_s = t_s;
    kick.place_mm = ball_on_floor();
    kick.is_chip = is_chip;
    kick.robot = kicker;
    double up = 0;
    if (is_chip) {
      const double rises_rad =
          chance_.uniform(options_.chip_rises_from_deg, options_.chip_rises_to_deg) * kPi / 180;
      up = speed * std::sin(rises_rad);
      speed *= std::cos(rises_rad);
    }
    Vector2d velocity = options_.kick_passes_on * at(kicker).velocity_mm_s + along(angle_rad) * speed;
    constexpr double kFastest = 6500;
    if (velocity.norm() > kFastest) velocity *= kFastest / velocity.norm();
    kick.velocity_mm_s << velocity, up;
    free_ = {};
    free_.is_rolling = false;
    free_.ramp_s = options_.kick_takes_s;
    free_.ramp_to = kick.velocity_mm_s;
    kicks.push_back(kick);
    last_kicker_ = kicker;
    last_kick_s_ = t_s;
    holder_ = -1;
  }

  void accelerate_ball() {
    ball_.velocity_mm_s += (free_.ramp_to - ball_.velocity_mm_s) * std::min(1.0, kStep_s / free_.ramp_s);
    ball_.place_mm += ball_.velocity_mm_s * kStep_s;
    free_.ramp_s -= kStep_s;
    if (free_.ramp_s > 1e-9) return;
    free_.ramp_s = 0;
    free_.slid_from_mm_s = ball_velocity().norm();
    free_.is_flying = ball_.velocity_mm_s.z() > 0;
  }

  void move_ball(double t_s) {
    if (free_.is_flying) {
      fly(t_s);
    } else {
      const double speed = ball_velocity().norm();
      if (!free_.is_rolling && speed < free_.slid_from_mm_s * 5 / 7) free_.is_rolling = true;
      const double slows = free_.is_rolling ? roll_mm_s2_ : slide_mm_s2_;
      const Vector2d velocity = unit(ball_velocity()) * std::max(0.0, speed - slows * kStep_s);
      ball_.velocity_mm_s << velocity, 0;
      ball_.place_mm += ball_.velocity_mm_s * kStep_s;
      ball_.place_mm.z() = World::kBallRadiusMm;
    }
    meet_walls(t_s);
    for (int i = 0; i < options_.robots && ball_.place_mm.z() <= 150; ++i) {
      if (i == last_kicker_ && t_s - last_kick_s_ < 0.15) continue;
      if (!meet(i, t_s)) break;
    }
  }

  void fly(double t_s) {
    ball_.velocity_mm_s.z() -= World::kGravityMm_s2 * kStep_s;
    ball_.place_mm += ball_.velocity_mm_s * kStep_s;
    if (ball_.place_mm.z() > World::kBallRadiusMm || ball_.velocity_mm_s.z() >= 0) return;
    ball_.place_mm.z() = World::kBallRadiusMm;
    turns.emplace_back(t_s, BallTurn::kBounce);
    if (free_.hops == 0 && !kicks.empty() && kicks.back().is_chip) {
      kicks.back().landing_mm = ball_on_floor();
      kicks.back().landing_s = t_s;
    }
    ball_.velocity_mm_s.z() *= -0.6;
    ball_.velocity_mm_s.head<2>() *= free_.hops == 0 ? 0.75 : 0.95;
    ++free_.hops;
    if (ball_.velocity_mm_s.z() >= 350) return;
    free_.is_flying = false;
    free_.is_rolling = true;
    ball_.velocity_mm_s.z() = 0;
  }

  void turned(double t_s, BallTurn turn) {
    turns.emplace_back(t_s, turn);
    if (free_.is_flying) return;
    free_.slid_from_mm_s = ball_velocity().norm();
    free_.is_rolling = false;
  }

  void meet_walls(double t_s) {
    constexpr std::array kWallsMm{6250.0, 4750.0};
    for (int axis = 0; axis < 2; ++axis) {
      if (std::abs(ball_.place_mm[axis]) < kWallsMm[static_cast<std::size_t>(axis)] ||
          ball_.place_mm[axis] * ball_.velocity_mm_s[axis] <= 0)
        continue;
      ball_.velocity_mm_s[axis] *= -0.5;
      turned(t_s, BallTurn::kWall);
    }
  }

  /// Returns false if the robot now holds the ball.
  bool meet(int i, double t_s) {
    const RobotTruth& robot = at(i);
    const Vector2d away = ball_on_floor() - robot.place_mm;
    if (away.norm() >= kTouchMm) return true;
    const Vector2d normal = unit(away);
    const Vector2d relative = ball_velocity() - robot.velocity_mm_s;
    const double into = relative.dot(normal);
    if (into < 0) {
      const bool is_in_front = std::abs(wrapped(std::atan2(away.y(), away.x()) - robot.angle_rad)) < 0.6;
      const bool is_slow = relative.norm() < 2500;
      if (is_in_front && !free_.is_flying && is_slow && (i == chaser_ || chance_.happens(0.5))) {
        holder_ = i;
        hold_until_s_ = t_s + chance_.uniform(0.3, 1.8);
        chaser_ = -1;
        turns.emplace_back(t_s, BallTurn::kCatch);
        return false;
      }
      if (is_in_front && !free_.is_flying && !is_slow && chance_.happens(0.3)) {
        kick(t_s, i, chance_.uniform(3000, 6000), robot.angle_rad, false);
        return false;
      }
      const Vector2d past = relative - normal * into;
      const Vector2d velocity = normal * (-0.45 * into) + past * 0.85 + robot.velocity_mm_s;
      ball_.velocity_mm_s.head<2>() = velocity;
      if (std::abs(into) > 150) turned(t_s, BallTurn::kDeflection);
    }
    ball_.place_mm.head<2>() = robot.place_mm + normal * (kTouchMm + 0.1);
    return true;
  }

  void choose_chaser(double t_s) {
    choose_again_s_ = t_s + 0.1;
    double best = 1e18;
    chaser_ = -1;
    if (options_.robots_stand) return;
    for (int i = 0; i < options_.robots; ++i) {
      const double distance = (at(i).place_mm - ball_on_floor() - 0.4 * ball_velocity()).norm();
      if (distance >= best || (i == last_kicker_ && t_s - last_kick_s_ < 0.6)) continue;
      best = distance;
      chaser_ = i;
    }
  }

  const WorldOptions& options_;
  halls::Chance& chance_;
  double slide_mm_s2_, roll_mm_s2_;
  std::vector<Driver> drivers_;
  std::vector<RobotTruth> robots_;
  BallTruth ball_;
  FreeBall free_;
  int holder_ = 0, chaser_ = -1, last_kicker_ = -1;
  double hold_until_s_ = 1, last_kick_s_ = -1, choose_again_s_ = 0;
};

Eigen::Matrix<double, 6, 1> terms_at(const WorldCamera& camera, const Vector2d& place_mm) {
  const double u = (place_mm.x() - camera.center_mm.x()) / 3000,
               v = (place_mm.y() - camera.center_mm.y()) / 2500;
  Eigen::Matrix<double, 6, 1> out;
  out << 1, u, v, u * u, u * v, v * v;
  return out;
}

/// A smooth position error with this rms over a camera's view.
WorldCamera::Terms some_bias(halls::Chance& chance, double rms_mm) {
  WorldCamera::Terms out;
  WorldCamera centre;
  for (int axis = 0; axis < 2; ++axis) {
    for (int i = 0; i < 6; ++i) out(axis, i) = chance.normal() * (i < 3 ? 1 : 0.8);
    double sum = 0;
    int count = 0;
    for (double u = -1; u <= 1; u += 0.2) {
      for (double v = -1; v <= 1; v += 0.2, ++count)
        sum += std::pow(out.row(axis).dot(terms_at(centre, {3000 * u, 2500 * v})), 2);
    }
    out.row(axis) *= 0.93 * rms_mm / std::sqrt(sum / count);
  }
  return out;
}

}  // namespace

/// A false ball that persists for some images.
struct Stray {
  int images = 0;
  BallSighting sighting{};
};

World::World(const WorldOptions& options) : options_(options), chance_(options.seed, "world") {
  place_cameras();
  heights_mm_.resize(static_cast<std::size_t>(options_.robots), kRobotHeightMm);
  if (options_.robot_height_spread_mm > 0) {
    halls::Chance chance(options_.seed, "heights");
    const double spread = options_.robot_height_spread_mm;
    for (double& height : heights_mm_) height += chance.uniform(-spread, spread);
  }
  swerves_.resize(static_cast<std::size_t>(options_.robots));
  play();
  look();
}

void World::place_cameras() {
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    WorldCamera& camera = cameras_[i];
    camera.center_mm = {(i / 2 ? 3000 : -3000) + chance_.uniform(-200, 200),
                        (i % 2 ? 2250 : -2250) + chance_.uniform(-200, 200), chance_.uniform(4500, 5500)};
    camera.clock_offset_s = options_.clock_offset_sigma_s * chance_.normal();
    camera.floor_bias = some_bias(chance_, options_.floor_bias_mm);
    const double more =
        std::sqrt(std::max(0.0, std::pow(options_.robot_bias_mm, 2) - std::pow(options_.floor_bias_mm, 2)));
    camera.robot_bias = camera.floor_bias + some_bias(chance_, more);
  }
}

void World::play() {
  Play play(options_, chance_);
  const auto steps = static_cast<std::size_t>(options_.duration_s / kStep_s) + 200;
  robots_.reserve(steps);
  balls_.reserve(steps);
  for (std::size_t i = 0; i < steps; ++i) {
    play.step(static_cast<double>(i) * kStep_s);
    robots_.push_back(play.robots());
    balls_.push_back(play.ball());
  }
  slides_mm_s2_ = play.slides_mm_s2();
  rolls_mm_s2_ = play.rolls_mm_s2();
  kicks_ = std::move(play.kicks);
  turns_ = std::move(play.turns);
  swerves_ = std::move(play.swerves);
  collisions_ = std::move(play.collisions);
}

RobotTruth World::robot(int robot, double t_s) const {
  const auto i =
      static_cast<std::size_t>(std::clamp(t_s / kStep_s, 0.0, static_cast<double>(robots_.size() - 2)));
  const double share = t_s / kStep_s - static_cast<double>(i);
  const RobotTruth &a = robots_[i][static_cast<std::size_t>(robot)],
                   &b = robots_[i + 1][static_cast<std::size_t>(robot)];
  return {a.place_mm + (b.place_mm - a.place_mm) * share,
          a.velocity_mm_s + (b.velocity_mm_s - a.velocity_mm_s) * share,
          wrapped(a.angle_rad + wrapped(b.angle_rad - a.angle_rad) * share),
          a.turn_rad_s + (b.turn_rad_s - a.turn_rad_s) * share};
}

BallTruth World::ball(double t_s) const {
  const auto i =
      static_cast<std::size_t>(std::clamp(t_s / kStep_s, 0.0, static_cast<double>(balls_.size() - 2)));
  const double share = t_s / kStep_s - static_cast<double>(i);
  const BallTruth &a = balls_[i], &b = balls_[i + 1];
  return {a.place_mm + (b.place_mm - a.place_mm) * share,
          a.velocity_mm_s + (b.velocity_mm_s - a.velocity_mm_s) * share, a.is_held};
}

double World::ball_slows_mm_s2(double t_s) const {
  const auto speed = [&](double at_s) { return ball(at_s).velocity_mm_s.head<2>().norm(); };
  return (speed(t_s) - speed(t_s + 0.005)) / 0.005;
}

Vector2d World::bias_of(const WorldCamera& camera, const Vector2d& place_mm, bool of_robots) const {
  const auto terms = terms_at(camera, place_mm);
  Vector2d out = (of_robots ? camera.robot_bias : camera.floor_bias) * terms;
  // A third of the bias cannot be modelled by a quadratic.
  const double wave = 0.35 * (of_robots ? options_.robot_bias_mm : options_.floor_bias_mm);
  const double u = terms[1], v = terms[2], phase = camera.center_mm.x();
  out += options_.outwards_mm * (place_mm - camera.center_mm.head<2>()).stableNormalized();
  return out + wave * Vector2d(std::sin(2.2 * u + 1.3 * v + phase), std::sin(1.7 * u - 2.1 * v + phase));
}

void World::look() {
  for (double t_s = 2; t_s < options_.duration_s;) {
    t_s -= std::log(chance_.uniform(1e-12, 1)) / std::max(1e-9, options_.occlusions_per_s);
    const double until_s = t_s + chance_.uniform(0.05, 0.3);
    occlusions_s_.emplace_back(t_s, until_s);
    t_s = until_s;
  }
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const double first_s = 0.1 + chance_.uniform(0, 1 / options_.rate_hz);
    const double rate_hz = options_.rate_hz * (1 + chance_.uniform(-3e-5, 3e-5));
    Stray stray;
    for (long number = 0;; ++number) {
      double t_s = first_s + static_cast<double>(number) / rate_hz;
      if (options_.uneven_sigma_s > 0)
        t_s += std::clamp(options_.uneven_sigma_s * chance_.normal(), -0.4 / rate_hz, 0.4 / rate_hz);
      if (t_s > options_.duration_s) break;
      see(static_cast<int>(i), number, t_s, stray);
    }
  }
  std::sort(images_.begin(), images_.end(),
            [](const WorldImage& a, const WorldImage& b) { return a.arrival_s < b.arrival_s; });
  for (KickTruth& kick : kicks_) {
    int before = 0, after = 0;
    for (const WorldImage& image : images_) {
      if (image.t_true_s > kick.t_s - 0.04 && image.t_true_s <= kick.t_s) before += image.true_balls;
      if (image.t_true_s > kick.t_s && image.t_true_s < kick.t_s + 0.04) after += image.true_balls;
    }
    kick.is_hidden =
        before == 0 || after < 2 || std::abs(kick.place_mm.x()) > 6200 || std::abs(kick.place_mm.y()) > 4700;
  }
}

Vector2d World::twin_mm(double t_s) {
  return {3000 + 800 * std::cos(t_s), 2500 + 500 * std::sin(t_s)};
}

/// For see_strangers(): measurements of objects that are not the field's robots or ball. They use separate
/// random numbers, so that they do not depend on other options.
constexpr double kTwinComes_s = 10;

void World::see_strangers(int index, double t_s, WorldImage& image) const {
  const WorldCamera& camera = cameras_[static_cast<std::size_t>(index)];
  const auto moment = static_cast<std::uint64_t>(t_s * 1e4);
  halls::Chance chance(options_.seed + 7 * static_cast<std::uint64_t>(index), "strangers", moment);
  const double side_x = camera.center_mm.x() > 0 ? 1 : -1, side_y = camera.center_mm.y() > 0 ? 1 : -1;
  const auto add_robot = [&](Team team, int id, const Vector2d& place, double angle_rad) {
    const Vector2d off(0.06 * chance.normal(), 0.06 * chance.normal());
    image.sightings.robots.push_back({team, id, place + off, angle_rad + 1e-3 * chance.normal(),
                                      kRobotHeightMm, Eigen::Matrix2d::Identity() * 0.0036, 1e-3});
  };
  if (options_.has_twin && t_s > kTwinComes_s && side_x > 0 && side_y > 0) {
    add_robot(team_of(0), id_of(0), twin_mm(t_s), wrapped(t_s));
  }
  if (options_.hands_share <= 0) return;
  // A person leans in for two seconds at a time, each time at a new place.
  constexpr double kLeans_s = 2;
  const auto visit = static_cast<std::uint64_t>(t_s / kLeans_s);
  halls::Chance visitor(options_.seed + 7 * static_cast<std::uint64_t>(index), "visitor", visit);
  if (!visitor.happens(options_.hands_share)) return;
  const Vector2d stands(side_x * visitor.uniform(800, 5500), side_y * visitor.uniform(4300, 4700));
  const Vector2d reaches(visitor.uniform(-300, 300), -side_y * visitor.uniform(0, 400));
  const double share = std::fmod(t_s, kLeans_s) / kLeans_s;
  const Vector2d hand = stands + reaches * std::sin(share * kPi);
  // Skin and a shirt's print: false balls, and sometimes a false robot.
  while (chance.happens(0.4)) {
    BallSighting ball{};
    ball.confidence = chance.uniform(0.3, 0.8);
    ball.place_mm = hand + Vector2d(30 * chance.normal(), 30 * chance.normal());
    ball.place_cov_mm2 = Eigen::Matrix2d::Identity() * 0.3;
    ball.height_mm = kBallRadiusMm + 90 * chance.normal();
    ball.height_sigma_mm = 70;
    image.sightings.balls.push_back(ball);
  }
  if (!chance.happens(0.05)) return;
  const Team team = chance.happens(0.5) ? Team::kYellow : Team::kBlue;
  const Vector2d off(60 * chance.normal(), 60 * chance.normal());
  add_robot(team, chance.whole(0, 15), hand + off, chance.uniform(-kPi, kPi));
}

void World::see(int index, long number, double t_s, Stray& stray) {
  const WorldCamera& camera = cameras_[static_cast<std::size_t>(index)];
  WorldImage image;
  image.t_true_s = t_s;
  image.arrival_s = t_s + options_.latency_s + chance_.uniform(0, options_.latency_spread_s);
  image.sightings.camera = index;
  image.sightings.camera_mm = camera.center_mm;
  image.sightings.frame_number = static_cast<std::uint32_t>(number);
  image.sightings.t_capture_s = t_s + camera.clock_offset_s + options_.jitter_sigma_s * chance_.normal();
  const double side_x = index / 2 ? 1 : -1, side_y = index % 2 ? 1 : -1;
  /// Cameras overlap by a metre.
  const auto is_in_view = [&](const Vector2d& place, double margin_mm) {
    const double x = place.x() * side_x, y = place.y() * side_y;
    return x > -500 + margin_mm && x < 6500 - margin_mm && y > -450 + margin_mm && y < 4950 - margin_mm;
  };
  const Vector2d below = camera.center_mm.head<2>();
  const auto off_axis = [&](const Vector2d& place) { return (place - below).norm() / 3800; };

  for (int i = 0; i < options_.robots; ++i) {
    const RobotTruth truth = robot(i, t_s);
    if (!is_in_view(truth.place_mm, 60) || chance_.happens(options_.drop_share)) continue;
    // A robot that is higher than assumed appears farther out.
    const double height = heights_mm_[static_cast<std::size_t>(i)];
    const Vector2d seen = below + (truth.place_mm - below) * (camera.center_mm.z() - kRobotHeightMm) /
                                      (camera.center_mm.z() - height);
    const Vector2d bias = bias_of(camera, seen, true);
    const double sigma = options_.noise * (0.035 + 0.025 * off_axis(seen));
    const double angle_sigma = options_.noise * (0.02 + 0.02 * off_axis(seen)) * kPi / 180;
    const auto off = [&] { return sigma * chance_.normal() + options_.wobble_mm * chance_.normal(); };
    const double off_x = off(), off_y = off();
    int id = id_of(i);
    if (options_.misread_share > 0 && chance_.happens(options_.misread_share)) id = chance_.whole(0, 15);
    image.sightings.robots.push_back(
        {team_of(i), id, seen + bias + Vector2d(off_x, off_y),
         wrapped(truth.angle_rad + angle_sigma * chance_.normal() + 0.0006 * bias.x()), kRobotHeightMm,
         Eigen::Matrix2d::Identity() * sigma * sigma, angle_sigma});
  }

  const auto add_ball = [&](const Vector3d& place) {
    const double share = (camera.center_mm.z() - kBallRadiusMm) / (camera.center_mm.z() - place.z());
    const Vector2d seen = below + (place.head<2>() - below) * share;
    if (!is_in_view(seen, 10) || chance_.happens(options_.drop_share)) return 0;
    const double sigma = options_.noise * (0.2 + 0.2 * off_axis(seen));
    const double off_x = sigma * chance_.normal(), off_y = sigma * chance_.normal();
    BallSighting ball{seen + bias_of(camera, seen, false) + Vector2d(off_x, off_y),
                      Eigen::Matrix2d::Identity() * sigma * sigma, chance_.uniform(0.85, 1)};
    // A ball closer to the camera appears larger.
    constexpr double kFocalPx = 1250;
    const double depth = (camera.center_mm - place).norm();
    const double radius_px =
        kFocalPx * kBallRadiusMm / depth + options_.ball_size_sigma_px * chance_.normal();
    const double floor_depth = std::hypot(camera.center_mm.z() - kBallRadiusMm, (seen - below).norm());
    const double share_left = kFocalPx * kBallRadiusMm / radius_px / floor_depth;
    ball.height_mm = kBallRadiusMm + (camera.center_mm.z() - kBallRadiusMm) * (1 - share_left);
    ball.height_sigma_mm =
        (camera.center_mm.z() - kBallRadiusMm) * 0.08 / (kFocalPx * kBallRadiusMm / floor_depth);
    image.sightings.balls.push_back(ball);
    return 1;
  };
  const BallTruth ball = this->ball(t_s);
  bool is_hidden = std::any_of(occlusions_s_.begin(), occlusions_s_.end(),
                               [&](const auto& one) { return t_s >= one.first && t_s < one.second; });
  // Occlusion by robots.
  const Vector2d on_floor = ball.place_mm.head<2>();
  const Vector2d towards = unit(below - on_floor);
  const double reach =
      (below - on_floor).norm() *
      std::max(0.0, (kRobotHeightMm - ball.place_mm.z()) / (camera.center_mm.z() - ball.place_mm.z()));
  for (int i = 0; i < options_.robots && !is_hidden; ++i) {
    const Vector2d robot_mm = robot(i, t_s).place_mm;
    const double nearest = std::clamp((robot_mm - on_floor).dot(towards), 0.0, reach);
    is_hidden = (on_floor + towards * nearest - robot_mm).norm() < 85;
  }
  if (!is_hidden) image.true_balls = add_ball(ball.place_mm);
  if (options_.has_second_ball) add_ball({kSecondBallMm.x(), kSecondBallMm.y(), kBallRadiusMm});
  if (options_.has_ball_on_robot) {
    const Vector2d robot_mm = robot(options_.robots - 1, t_s).place_mm;
    add_ball({robot_mm.x(), robot_mm.y(), kRobotHeightMm});
  }
  see_strangers(index, t_s, image);

  if (stray.images > 0) {
    --stray.images;
    BallSighting again = stray.sighting;
    again.place_mm += Vector2d(chance_.normal(), chance_.normal());
    image.sightings.balls.push_back(again);
  } else if (chance_.happens(options_.false_ball_share)) {
    BallSighting one{};
    one.confidence = chance_.uniform(0.5, 0.9);
    one.place_mm = {side_x * chance_.uniform(0, 6300), side_y * chance_.uniform(0, 4800)};
    if (chance_.happens(0.5)) {  // next to a robot
      const int at = chance_.whole(0, options_.robots - 1);
      one.place_mm = robot(at, t_s).place_mm + 120 * along(chance_.uniform(-kPi, kPi));
    }
    one.place_cov_mm2 = Eigen::Matrix2d::Identity() * 0.1;
    one.height_mm = kBallRadiusMm + 60 * chance_.normal();
    one.height_sigma_mm = 70;
    image.sightings.balls.push_back(one);
    if (chance_.happens(0.15)) stray = {chance_.whole(1, 4), one};
  }
  if (options_.camera_dies_s && index == 1 && t_s > *options_.camera_dies_s) return;
  images_.push_back(std::move(image));
}

}  // namespace sslv::worlds
