// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/scene.h"
#include "tracking/tracks.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// A robot as one camera saw it.
struct RobotSighting {
  Team team;
  int id;
  Eigen::Vector2d place_mm;  // on the plane z = height_mm
  double orientation_rad;
  double height_mm;
  Eigen::Matrix2d place_cov_mm2;  // from the fit alone, without calibration errors
  double orientation_sigma_rad;
};

/// A ball as one camera saw it, as if it lay on the floor.
struct BallSighting {
  Eigen::Vector2d place_mm;  // on the plane z = the ball's radius
  Eigen::Matrix2d place_cov_mm2;
  double confidence;  // 0 .. 1
  /// Height of the ball's centre, from its size in the image; far less certain than the position.
  double height_mm = 0, height_sigma_mm = std::numeric_limits<double>::infinity();
};

/// Robots and balls that one camera saw in one image.
struct CameraSightings {
  int camera = 0;
  std::uint32_t frame_number = 0;
  bool is_taken = true;                // false: the image is dropped
  bool is_of_other_computer = false;   // other computers send no covariances
  double t_capture_s = 0;              // Unix time by the clock of the camera's computer
  Eigen::Vector3d camera_mm{0, 0, 0};  // position of the camera
  std::vector<RobotSighting> robots;
  std::vector<BallSighting> balls;
};

/// Measurements received from a camera, validated (pipeline/validate.h): finite and in range.
struct ArrivedSightings {
  CameraSightings image;
  std::int64_t handed_over_ns = 0;  // steady_ns(); 0: not from a live camera
  std::uint64_t left_out = 0;       // number of dropped robots and balls
};

/// Capture time of an image, estimated from its time stamp and the rate of its camera (see Clocks). Empty if
/// the image was dropped.
struct ImageTime {
  std::optional<double> t_s;
  double sigma_s = 0;
  double evenness = 0;  // see Evenness::share()
};

/// Measurement of a robot, corrected by its camera's known errors.
struct RobotObservation {
  RobotName name;
  int camera;
  double t_s, t_sigma_s;
  Eigen::Vector2d place_mm;
  double orientation_rad;
  Eigen::Matrix2d place_cov_mm2;
  double orientation_sigma_rad;
  double height_mm = 0;               // height of the robot's pattern
  bool is_of_other_computer = false;  // RobotTracks prefers this computer's cameras
};

/// Measurement of a ball; its time is corrected by the camera's known offset, its position is not corrected.
struct BallObservation {
  double t_s;
  Eigen::Vector3d camera_mm;
  Eigen::Vector2d place_mm;  // as if the ball were on the floor
  double sigma_mm;
  double height_mm, height_sigma_mm;
  bool is_over_robot = false;  // in front of a robot's top: on it, or in the air, but not on the floor
};

/// Measurements of one image; both lists are empty if the image was dropped.
struct Observations {
  std::vector<RobotObservation> robots;
  std::vector<BallObservation> balls;
};

}  // namespace sslv
