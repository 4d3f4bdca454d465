// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "hall.h"
#include "solids.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace sslv::halls {

struct PlayedRobot {
  std::size_t team;  // 0 yellow, 1 blue
  int id;
  double orientation_rad;
  Robot solid;
  double share = 1;  // fraction of its top visible to the camera
};

struct PlayedBall {
  Eigen::Vector2d at_mm;
  Motion motion{};
  double share = 1;  // visible fraction of its disc
};

/// The robots and balls of one frame.
struct Play {
  std::vector<PlayedRobot> robots;
  std::vector<PlayedBall> balls;
};

enum class Placement : std::uint8_t {
  kScatter,  // new places in every frame
  kPaths,    // each robot and ball on its own small loop, at 60 frames per second
};
constexpr double kFramesPerSecond = 60;

struct PlayOptions {
  Placement placement = Placement::kScatter;
  int robots = 6;  // per team
  int balls = 2;
  double speed_mm_s = 0;  // of the fastest; 0: unscaled on paths, at rest when scattered
};

/// Parts of the camera's image in which nothing may be placed.
class Obstacles {
 public:
  Obstacles(const CameraModel& camera, std::vector<std::uint8_t> mask)
      : camera_(camera), mask_(std::move(mask)) {}
  /// Whether an upright cylinder there neither hides anything nor is hidden.
  bool leave_free(const Eigen::Vector2d& at_mm, double radius_mm, double height_mm) const;

 private:
  const CameraModel& camera_;
  std::vector<std::uint8_t> mask_;  // nonzero: occupied
};

/// Places robots and balls within the camera's image. The same seed and frame give the same places.
class Game {
 public:
  Game(const Hall& hall, const CameraModel& camera, const Obstacles& obstacles, const PlayOptions& options);
  Play at(int frame) const;

 private:
  /// The elliptic path of a robot or ball.
  struct Round {
    Eigen::Vector2d middle_mm, half_axes_mm;
    double phase_rad, turn_rad_s, spin_rad_s;
    std::size_t team;
    int id;  // -1: a ball
  };
  Play scattered(int frame) const;
  Play on_paths(int frame) const;
  void plan_paths();
  std::optional<Eigen::Vector2d> random_place(Chance& chance, double height_mm, double beyond_lines_mm) const;
  void place_ball(Chance& chance, Play& play) const;
  void measure_shares(Play& play) const;
  Motion random_motion(Chance& chance, double spin_rad_s) const;
  /// By how much two objects may approach each other during an exposure.
  double approach_mm() const { return options_.speed_mm_s * hall_.sensor.exposure_s; }
  double ball_share(const Eigen::Vector2d& at_mm, const Play& play) const;

  const Hall& hall_;
  const CameraModel& camera_;
  const Obstacles& obstacles_;
  PlayOptions options_;
  std::vector<Round> rounds_;
};

}  // namespace sslv::halls
