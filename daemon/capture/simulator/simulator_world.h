// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_paths.h"
#include "capture/simulator/simulator_scatter.h"
#include "capture/simulator/simulator_scene.h"

#include <array>
#include <span>
#include <variant>

namespace sslv {

/// The positions of all things, which depend only on the options and the time, so that all cameras with the
/// same options agree and tests know the ground truth. Distractors lie below everything else.
class SimulatedWorld {
 public:
  /// Balls are hidden from `camera`, so worlds with hidden_balls differ between cameras. Throws SettingsError
  /// if there is no space for all things, or for hidden_balls without a camera.
  SimulatedWorld(const SimulatorOptions& options, const FieldSize& field,
                 const std::array<double, 2>& robot_height_mm, const CameraModel* camera = nullptr);

  /// The scene at a Unix time; with scatter, the scene in the middle of the slot. Orientations are in (-pi,
  /// pi].
  SimulatedScene at(double t_s) const;

  /// Fills `moments` with scenes evenly spaced over an exposure centred at t_s.
  void expose(double t_s, double exposure_s, std::span<SimulatedScene> moments) const;

  /// Motion of all things around t_s, interpolated through their positions at t_s - reach_s, t_s and t_s +
  /// reach_s.
  SimulatorMotions motions_at(double t_s, double reach_s) const;

 private:
  std::variant<SimulatorPaths, SimulatorScatter> placement_;
};

}  // namespace sslv
