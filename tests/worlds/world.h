// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../halls/chance.h"
#include "tracking/sightings.h"

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sslv::worlds {

/// Events on the field and properties of the cameras. Defaults: as in the table of docs/measured/tracking.md.
struct WorldOptions {
  std::uint64_t seed = 1;
  double duration_s = 60;
  int robots = 22;
  double rate_hz = 75;
  double latency_s = 0.015, latency_spread_s = 0.002;  // from exposure to the measurements
  double clock_offset_sigma_s = 0.4e-3;                // of each camera's timestamps
  double jitter_sigma_s = 0.2e-3;                      // of each timestamp
  double uneven_sigma_s = 0;                           // of the true times of the images
  double floor_bias_mm = 1, robot_bias_mm = 2.5;       // rms of the calibration errors
  double outwards_mm = 0;                              // each camera sees everything so much too far out
  double ball_size_sigma_px = 0.08;
  double drop_share = 0.02;           // fraction of missing measurements
  double false_ball_share = 0.02;     // fraction of images with a false ball
  double occlusions_per_s = 0.3;      // of the ball, for .05 to .3 s, for all cameras
  double wobble_mm = 0;               // of robots, faster than real motion
  double noise = 1;                   // of measurements, relative to the usual noise
  double robot_height_spread_mm = 0;  // each robot's deviation from its team's height, uniform
  bool only_chips = false;
  bool robots_stand = false;
  bool has_second_ball = false;    // at rest, at kSecondBallMm
  bool robots_collide = false;     // and often drive into each other; otherwise they pass through
  double misread_share = 0;        // fraction of robots measured with another id of the same team
  bool has_twin = false;           // another robot has the pattern of the first one
  bool has_ball_on_robot = false;  // an object on the last robot looks like a ball
  double hands_share = 0;          // fraction of time with hands and shirts at the field's edge
  double kick_takes_s = 3e-3;
  double kick_passes_on = 0.5;  // fraction of the robot's velocity passed on to the kicked ball
  double chip_rises_from_deg = 42, chip_rises_to_deg = 48;
  std::optional<double> camera_dies_s;  // camera 1 sends nothing from then on
};

struct RobotTruth {
  Eigen::Vector2d place_mm{0, 0}, velocity_mm_s{0, 0};
  double angle_rad = 0, turn_rad_s = 0;
};

struct BallTruth {
  Eigen::Vector3d place_mm{0, 0, 0}, velocity_mm_s{0, 0, 0};
  bool is_held = false;
};

struct KickTruth {
  double t_s = 0;
  Eigen::Vector2d place_mm{0, 0};
  Eigen::Vector3d velocity_mm_s{0, 0, 0};
  bool is_chip = false;
  Eigen::Vector2d landing_mm{0, 0};
  double landing_s = 0;    // 0: it did not land
  bool is_hidden = false;  // not seen shortly before, or less than twice shortly after
  int robot = -1;
};

/// Changes of the ball's direction other than kicks.
enum class BallTurn { kDeflection, kWall, kCatch, kBounce };

struct WorldCamera {
  Eigen::Vector3d center_mm{0, 0, 0};
  double clock_offset_s = 0;
  using Terms = Eigen::Matrix<double, 2, 6>;
  Terms floor_bias = Terms::Zero(), robot_bias = Terms::Zero();
};

/// One image of one camera, with ground truth that trackers do not get.
struct WorldImage {
  CameraSightings sightings;
  double t_true_s = 0, arrival_s = 0;
  int true_balls = 0;  // the first ones in sightings.balls
};

/// A field of 12 x 9 m under four cameras, with robots that drive, catch, dribble and kick the ball, in steps
/// of a millisecond. It draws no images: measurements get errors like those of the real detectors.
class World {
 public:
  explicit World(const WorldOptions& options);

  RobotTruth robot(int robot, double t_s) const;
  BallTruth ball(double t_s) const;
  /// Deceleration along its direction over the next 5 ms, mm/s2.
  double ball_slows_mm_s2(double t_s) const;
  static Team team_of(int robot) { return robot % 2 ? Team::kBlue : Team::kYellow; }
  static int id_of(int robot) { return robot / 2; }
  static int robot_of(Team team, int id) { return 2 * id + (team == Team::kBlue ? 1 : 0); }
  /// Times at which this robot was pushed by another one.
  const std::vector<double>& collisions_of(int robot) const {
    return collisions_[static_cast<std::size_t>(robot)];
  }

  const WorldOptions& options() const { return options_; }
  const std::array<WorldCamera, 4>& cameras() const { return cameras_; }
  const std::vector<WorldImage>& images() const { return images_; }  // in order of arrival
  const std::vector<KickTruth>& kicks() const { return kicks_; }
  const std::vector<std::pair<double, BallTurn>>& turns() const { return turns_; }
  /// Times at which this robot's acceleration changed by more than 5 m/s2 within 60 ms.
  const std::vector<double>& swerves_of(int robot) const { return swerves_[static_cast<std::size_t>(robot)]; }
  /// Decelerations of the ball when sliding and rolling.
  double slides_mm_s2() const { return slides_mm_s2_; }
  double rolls_mm_s2() const { return rolls_mm_s2_; }
  double height_of(int robot) const { return heights_mm_[static_cast<std::size_t>(robot)]; }

  static constexpr double kBallRadiusMm = 21.5, kRobotHeightMm = 145, kGravityMm_s2 = 9810;
  /// Position of the robot with the same pattern as the first one.
  static Eigen::Vector2d twin_mm(double t_s);
  inline static const Eigen::Vector2d kSecondBallMm{-2000, 4300};
  static constexpr double kHalfLengthMm = 6000, kHalfWidthMm = 4500;

 private:
  void place_cameras();
  void play();
  void look();
  void see(int camera, long number, double t_s, struct Stray& stray);
  void see_strangers(int camera, double t_s, WorldImage& image) const;
  Eigen::Vector2d bias_of(const WorldCamera& camera, const Eigen::Vector2d& place_mm, bool of_robots) const;

  const WorldOptions options_;
  halls::Chance chance_;
  std::array<WorldCamera, 4> cameras_;
  std::vector<std::vector<RobotTruth>> robots_;  // for each millisecond
  std::vector<BallTruth> balls_;
  std::vector<double> heights_mm_;
  double slides_mm_s2_ = 0, rolls_mm_s2_ = 0;
  std::vector<KickTruth> kicks_;
  std::vector<std::pair<double, BallTurn>> turns_;
  std::vector<std::vector<double>> swerves_, collisions_;
  std::vector<std::pair<double, double>> occlusions_s_;
  std::vector<WorldImage> images_;
};

}  // namespace sslv::worlds
