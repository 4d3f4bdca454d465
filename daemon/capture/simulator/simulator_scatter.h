// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_scene.h"
#include "geometry/camera_model.h"

#include <array>
#include <cstdint>
#include <optional>

namespace sslv {

/// All things during one slot, and their motion.
struct SimulatorSlot {
  SimulatedScene scene;
  boost::container::static_vector<SimulatorMotion, SimulatedScene::kMaxRobots> robot_motion;
  boost::container::static_vector<SimulatorMotion, SimulatedScene::kMaxBalls> ball_motion;
  const char* no_room_for = nullptr;  // option of a thing that did not fit; null: all fit

  /// The scene dt_s after the slot's middle.
  SimulatedScene at(double dt_s) const;
};

/// Places all things at new random positions in each slot of one frame period, with the gaps below. Things
/// move only while an image is exposed. In the rare case that a slot has no space for a thing, the thing is
/// omitted.
class SimulatorScatter {
 public:
  // Minimum gaps that differ from kSimulatorClearanceMm. kBallClearanceMm is the gap from a ball to robots
  // and other balls, except to the robot that hides the ball.
  static constexpr double kBallClearanceMm = 60;
  static constexpr double kDistractorToBallMm = 40, kBetweenDistractorsMm = 10;

  /// Throws SettingsError if there is no space for all things, or for hidden_balls without a camera.
  SimulatorScatter(const SimulatorOptions& options, const FieldSize& field,
                   const std::array<double, 2>& robot_height_mm, const std::optional<CameraModel>& camera);

  /// The slot that contains Unix time t_s.
  SimulatorSlot slot_at(double t_s) const;

 private:
  SimulatorSlot fill(std::int64_t slot) const;

  SimulatorOptions options_;
  FieldSize field_;
  std::array<double, 2> robot_height_mm_;
  std::optional<CameraModel> camera_;
};

}  // namespace sslv
