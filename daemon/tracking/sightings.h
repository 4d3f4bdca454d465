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
  Eigen::Matrix2d place_cov_mm2;  // of the fit alone, without what the calibration adds
  double orientation_sigma_rad;
};

/// A ball as one camera saw it, as if it lay on the floor.
struct BallSighting {
  Eigen::Vector2d place_mm;  // on the plane z = the ball's radius
  Eigen::Matrix2d place_cov_mm2;
  double confidence;  // 0 .. 1
  /// Of its centre, as its size in the image tells; far less sure than its place.
  double height_mm = 0, height_sigma_mm = std::numeric_limits<double>::infinity();
};

/// What one camera saw in one image.
struct CameraSightings {
  int camera = 0;
  std::uint32_t frame_number = 0;
  bool is_taken = true;                // false: the image is left out
  bool is_of_other_computer = false;   // which says nothing of how sure its places are
  double t_capture_s = 0;              // Unix time, as the camera's computer says
  Eigen::Vector3d camera_mm{0, 0, 0};  // where the camera hangs
  std::vector<RobotSighting> robots;
  std::vector<BallSighting> balls;
};

/// What came in from a camera, validated (pipeline/senseless.h): finite and in range.
struct ArrivedSightings {
  CameraSightings image;
  std::int64_t handed_over_ns = 0;  // steady_ns(); 0: of no live camera
  std::uint64_t left_out = 0;       // robots and balls that were dropped
};

/// When an image was taken, as its camera's even rate has it. Nothing for an image that is left out.
struct ImageTime {
  std::optional<double> t_s;
  double sigma_s = 0;
};

/// A sighting of a robot without what is known of its camera's errors.
struct RobotObservation {
  RobotName name;
  int camera;
  double t_s, t_sigma_s;
  Eigen::Vector2d place_mm;
  double orientation_rad;
  Eigen::Matrix2d place_cov_mm2;
  double orientation_sigma_rad;
  double height_mm = 0;               // of its pattern
  bool is_of_other_computer = false;  // RobotTracks believes this one's cameras rather
};

/// Likewise of a ball.
struct BallObservation {
  double t_s;
  Eigen::Vector3d camera_mm;
  Eigen::Vector2d place_mm;  // as if on the floor
  double sigma_mm;
  double height_mm, height_sigma_mm;
  bool is_over_robot = false;  // in front of a robot's top: on it, or in the air, but not on the floor
};

/// What one image shows; both lists are empty when it is left out.
struct Observations {
  std::vector<RobotObservation> robots;
  std::vector<BallObservation> balls;
};

}  // namespace sslv
