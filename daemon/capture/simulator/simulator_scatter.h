// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_scene.h"
#include "geometry/camera_model.h"

#include <array>
#include <cstdint>
#include <optional>

namespace sslv {

/// Everything during one slot, and how it moves.
struct SimulatorSlot {
  SimulatedScene scene;
  boost::container::static_vector<SimulatorMotion, SimulatedScene::kMaxRobots> robot_motion;
  boost::container::static_vector<SimulatorMotion, SimulatedScene::kMaxBalls> ball_motion;
  const char* no_room_for = nullptr;  // option whose things did not all find a place

  /// Where everything is dt_s after the slot's middle.
  SimulatedScene at(double dt_s) const;
};

/// Everything at another random place in each slot of one frame period, apart from each other as said below.
/// It moves only while an image is exposed. Should a slot have no place for something, which is rare, it is
/// left out.
class SimulatorScatter {
 public:
  // Least gaps that differ from kSimulatorClearanceMm. A ball's to robots and other balls; the robot that it
  // hides behind may be nearer.
  static constexpr double kBallClearanceMm = 60;
  static constexpr double kDistractorToBallMm = 40, kBetweenDistractorsMm = 10;

  /// Throws SettingsError when there is no room for all of them, or hidden_balls without a camera.
  SimulatorScatter(const SimulatorOptions& options, const FieldSize& field,
                   const std::array<double, 2>& robot_height_mm, const std::optional<CameraModel>& camera);

  /// The slot that the Unix time t_s lies in.
  SimulatorSlot slot_at(double t_s) const;

 private:
  SimulatorSlot fill(std::int64_t slot) const;

  SimulatorOptions options_;
  FieldSize field_;
  std::array<double, 2> robot_height_mm_;
  std::optional<CameraModel> camera_;
};

}  // namespace sslv
