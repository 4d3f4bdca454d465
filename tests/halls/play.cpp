// SPDX-License-Identifier: Apache-2.0
#include "play.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace sslv::halls {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

bool is_in_picture(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 &&
         pixel.x() <= camera.calibration().pixel_image_width - 0.5 &&
         pixel.y() <= camera.calibration().pixel_image_height - 0.5;
}

/// Fraction of the points that are within the image and not hidden by a robot other than `own`.
double share_seen(const CameraModel& camera, const std::vector<Eigen::Vector3d>& points,
                  const std::vector<PlayedRobot>& robots, const PlayedRobot* own) {
  std::size_t seen = 0;
  for (const Eigen::Vector3d& point : points) {
    const auto pixel = camera.project(point);
    if (!pixel || !is_in_picture(camera, *pixel)) continue;
    const Ray ray{camera.position_mm(), point - camera.position_mm()};
    const bool is_hidden = std::any_of(robots.begin(), robots.end(), [&](const PlayedRobot& robot) {
      if (&robot == own || (robot.solid.at_mm() - point.head<2>()).norm() > 400) return false;
      const auto hit = robot.solid.hit(ray);
      return hit && hit->along < 1;
    });
    if (!is_hidden) ++seen;
  }
  return static_cast<double>(seen) / static_cast<double>(points.size());
}

double wrapped(double angle_rad) {
  const double out = std::remainder(angle_rad, kTurn);
  return out <= -std::numbers::pi ? std::numbers::pi : out;
}

}  // namespace

bool Obstacles::leave_free(const Eigen::Vector2d& at_mm, double radius_mm, double height_mm) const {
  const int width = camera_.calibration().pixel_image_width,
            height = camera_.calibration().pixel_image_height;
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  for (const double z : {0.0, height_mm}) {
    for (int i = 0; i < 12; ++i) {
      const double angle = i * kTurn / 12;
      const auto pixel = camera_.project(
          {at_mm.x() + radius_mm * std::cos(angle), at_mm.y() + radius_mm * std::sin(angle), z});
      if (!pixel) return false;
      left = std::min(left, pixel->x());
      right = std::max(right, pixel->x());
      top = std::min(top, pixel->y());
      bottom = std::max(bottom, pixel->y());
    }
  }
  constexpr int kMarginPx = 4;
  for (int y = std::max(0, static_cast<int>(top) - kMarginPx);
       y < std::min(height, static_cast<int>(bottom) + kMarginPx + 1); ++y) {
    for (int x = std::max(0, static_cast<int>(left) - kMarginPx);
         x < std::min(width, static_cast<int>(right) + kMarginPx + 1); ++x) {
      if (mask_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x)] != 0)
        return false;
    }
  }
  return true;
}

Game::Game(const Hall& hall, const CameraModel& camera, const Obstacles& obstacles,
           const PlayOptions& options)
    : hall_(hall), camera_(camera), obstacles_(obstacles), options_(options) {
  if (options.placement == Placement::kPaths) plan_paths();
}

Play Game::at(int frame) const {
  Play play = options_.placement == Placement::kPaths ? on_paths(frame) : scattered(frame);
  measure_shares(play);
  return play;
}

/// A random visible place, at most `beyond_lines_mm` outside the lines.
std::optional<Eigen::Vector2d> Game::random_place(Chance& chance, double height_mm,
                                                  double beyond_lines_mm) const {
  const auto& c = camera_.calibration();
  const Eigen::Vector2d pixel(chance.uniform(0, c.pixel_image_width - 1),
                              chance.uniform(0, c.pixel_image_height - 1));
  auto at = camera_.unproject(pixel, height_mm);
  if (!at || std::abs(at->x()) > hall_.field.field_length / 2.0 + beyond_lines_mm ||
      std::abs(at->y()) > hall_.field.field_width / 2.0 + beyond_lines_mm) {
    return std::nullopt;
  }
  return at;
}

Play Game::scattered(int frame) const {
  Chance chance(hall_.seed, "scatter", static_cast<std::uint64_t>(frame));
  Play play;
  for (std::size_t team = 0; team < 2; ++team) {
    std::vector<int> ids(16);
    for (int id = 0; id < 16; ++id) ids[static_cast<std::size_t>(id)] = id;
    for (std::size_t i = 0; i < static_cast<std::size_t>(options_.robots); ++i) {
      std::swap(ids[i], ids[i + chance.bits() % (16 - i)]);
      const Robot::Look look = hall_.robot_look(team, ids[i]);
      const Motion motion = random_motion(chance, 6);
      for (int tries = 0;; ++tries) {
        if (tries == 3000) throw std::runtime_error("there is no room for so many robots");
        // One robot in six nearly touches another.
        std::optional<Eigen::Vector2d> at;
        if (!play.robots.empty() && tries < 50 && chance.happens(0.16)) {
          const Robot& other = play.robots[chance.bits() % play.robots.size()].solid;
          const double angle = chance.uniform(0, kTurn);
          const double apart =
              look.radius_mm + other.look().radius_mm + approach_mm() + chance.uniform(3, 15);
          at = other.at_mm() + apart * Eigen::Vector2d(std::cos(angle), std::sin(angle));
        } else {
          at = random_place(chance, look.height_mm, 60);
        }
        if (!at || std::abs(at->x()) > hall_.field.field_length / 2.0 + 60 ||
            std::abs(at->y()) > hall_.field.field_width / 2.0 + 60)
          continue;
        const bool is_clear =
            std::all_of(play.robots.begin(), play.robots.end(), [&](const PlayedRobot& other) {
              return (other.solid.at_mm() - *at).norm() >
                     look.radius_mm + other.solid.look().radius_mm + approach_mm() + 2.5;
            });
        if (!is_clear || !obstacles_.leave_free(*at, 92, look.height_mm)) continue;
        const double orientation = wrapped(chance.uniform(0, kTurn));
        play.robots.push_back({team, ids[i], orientation, Robot(*at, orientation, look, motion)});
        break;
      }
    }
  }
  for (int i = 0; i < options_.balls; ++i) place_ball(chance, play);
  return play;
}

double Game::ball_share(const Eigen::Vector2d& at_mm, const Play& play) const {
  // The ball's disc as seen by the camera, through its centre.
  const Eigen::Vector3d center(at_mm.x(), at_mm.y(), Ball::kRadiusMm);
  const Eigen::Vector3d view = (center - camera_.position_mm()).normalized();
  const Eigen::Vector3d across = view.unitOrthogonal(), up = view.cross(across);
  std::vector<Eigen::Vector3d> points;
  constexpr int kSide = 12;
  for (int i = -kSide; i <= kSide; ++i) {
    for (int j = -kSide; j <= kSide; ++j) {
      if (i * i + j * j <= kSide * kSide)
        points.push_back(center + (across * i + up * j) * (Ball::kRadiusMm / kSide));
    }
  }
  return share_seen(camera_, points, play.robots, nullptr);
}

Motion Game::random_motion(Chance& chance, double spin_rad_s) const {
  if (options_.speed_mm_s <= 0) return {};
  const double angle = chance.uniform(0, kTurn), speed = options_.speed_mm_s * chance.uniform(0.3, 1);
  return {speed * Eigen::Vector2d(std::cos(angle), std::sin(angle)), chance.uniform(-spin_rad_s, spin_rad_s)};
}

/// Places the ball in the open, on a line, beside a robot or behind one.
void Game::place_ball(Chance& chance, Play& play) const {
  const bool is_hard = hall_.options.kind == Kind::kHard;
  const double kind = chance.uniform(0, 1);
  const bool on_line = kind < (is_hard ? 0.2 : 0.1);
  const bool hidden = is_hard && kind > 0.8;
  const bool beside = !on_line && !hidden && kind > (is_hard ? 0.6 : 0.85);
  for (int tries = 0; tries < 5000; ++tries) {
    std::optional<Eigen::Vector2d> at;
    if (on_line) {
      const auto& stripes = hall_.floor.stripes;
      const Stripe& line = stripes[chance.bits() % stripes.size()];
      if (line.in_the_way) continue;
      at = line.a_mm + chance.uniform(0, 1) * (line.b_mm - line.a_mm) +
           Eigen::Vector2d(chance.uniform(-15, 15), chance.uniform(-15, 15));
    } else if ((beside || hidden) && !play.robots.empty()) {
      const Robot& robot = play.robots[chance.bits() % play.robots.size()].solid;
      const double angle = chance.uniform(0, kTurn), apart = chance.uniform(75, 150);
      at = robot.at_mm() + apart * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    } else {
      at = random_place(chance, 0, 20);
    }
    if (!at) continue;
    const double to_robot_mm = [&] {
      double least = 1e9;
      for (const PlayedRobot& robot : play.robots)
        least = std::min(least, robot.solid.distance_to_outline_mm(*at));
      return least;
    }();
    const double to_ball_mm = [&] {
      double least = 1e9;
      for (const PlayedBall& ball : play.balls) least = std::min(least, (ball.at_mm - *at).norm());
      return least;
    }();
    if (to_robot_mm < Ball::kRadiusMm + approach_mm() + 1 || to_ball_mm < 2 * Ball::kRadiusMm + 40) continue;
    if ((beside || hidden) && to_robot_mm > Ball::kRadiusMm + approach_mm() + 25) continue;
    if (!obstacles_.leave_free(*at, Ball::kRadiusMm + 2, 2 * Ball::kRadiusMm)) continue;
    const auto pixel = camera_.project({at->x(), at->y(), Ball::kRadiusMm});
    if (!pixel || !is_in_picture(camera_, *pixel)) continue;
    const double share = ball_share(*at, play);
    if (hidden ? share < 0.4 || share > 0.75 : share < 1) continue;
    play.balls.push_back({*at, random_motion(chance, 0), share});
    return;
  }
}

/// Assigns each robot and ball a cell of the field that it does not leave.
void Game::plan_paths() {
  Chance chance(hall_.seed, "paths");
  const int robots = 2 * options_.robots;
  for (double cell_mm = 1100; rounds_.size() < static_cast<std::size_t>(robots + options_.balls);
       cell_mm *= 0.93) {
    if (cell_mm < 240) throw std::runtime_error("there is no room for so many robots on paths");
    rounds_.clear();
    std::vector<Round> free;
    const double half_x = hall_.field.field_length / 2.0, half_y = hall_.field.field_width / 2.0;
    for (double x = -half_x + cell_mm / 2; x < half_x; x += cell_mm) {
      for (double y = -half_y + cell_mm / 2; y < half_y; y += cell_mm) {
        const double room = cell_mm / 2 - 95;
        const auto pixel = camera_.project({x, y, kNominalHeightMm});
        if (!pixel || !is_in_picture(camera_, *pixel) ||
            !obstacles_.leave_free({x, y}, cell_mm / 2, kNominalHeightMm + 10))
          continue;
        free.push_back({{x, y},
                        {room * chance.uniform(0.3, 1), room * chance.uniform(0.3, 1)},
                        chance.uniform(0, kTurn),
                        chance.sign() * chance.uniform(0.3, 1.6),
                        chance.uniform(-2, 2),
                        0,
                        0});
      }
    }
    for (std::size_t i = 0; i < free.size(); ++i)
      std::swap(free[i], free[i + chance.bits() % (free.size() - i)]);
    for (std::size_t i = 0; i < free.size() && i < static_cast<std::size_t>(robots + options_.balls); ++i) {
      const int number = static_cast<int>(i);
      Round round = free[i];
      round.team = number < options_.robots ? 0 : 1;
      round.id =
          number >= robots ? -1 : (number % options_.robots * 5 + static_cast<int>(hall_.seed % 16)) % 16;
      rounds_.push_back(round);
    }
  }
  if (options_.speed_mm_s <= 0) return;
  double fastest_mm_s = 0;
  for (const Round& round : rounds_) {
    fastest_mm_s = std::max(fastest_mm_s, std::abs(round.turn_rad_s) * round.half_axes_mm.maxCoeff());
  }
  for (Round& round : rounds_) round.turn_rad_s *= options_.speed_mm_s / fastest_mm_s;
}

Play Game::on_paths(int frame) const {
  const double t = frame / kFramesPerSecond;
  Play play;
  for (const Round& round : rounds_) {
    const double angle = round.phase_rad + round.turn_rad_s * t;
    const Eigen::Vector2d at = round.middle_mm + Eigen::Vector2d(round.half_axes_mm.x() * std::cos(angle),
                                                                 round.half_axes_mm.y() * std::sin(angle));
    const Motion motion{{-round.half_axes_mm.x() * std::sin(angle) * round.turn_rad_s,
                         round.half_axes_mm.y() * std::cos(angle) * round.turn_rad_s},
                        round.id < 0 ? 0 : round.spin_rad_s};
    if (round.id < 0) {
      play.balls.push_back({at, motion});
    } else {
      const double orientation = wrapped(round.phase_rad + round.spin_rad_s * t);
      play.robots.push_back({round.team, round.id, orientation,
                             Robot(at, orientation, hall_.robot_look(round.team, round.id), motion)});
    }
  }
  for (PlayedBall& ball : play.balls) ball.share = ball_share(ball.at_mm, play);
  return play;
}

void Game::measure_shares(Play& play) const {
  for (PlayedRobot& robot : play.robots) {
    robot.share = share_seen(camera_, robot.solid.top_points(), play.robots, &robot);
  }
}

}  // namespace sslv::halls
