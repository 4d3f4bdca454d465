// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_paths.h"
#include "capture/simulator/simulator_scatter.h"
#include "capture/simulator/simulator_scene.h"

#include <array>
#include <span>
#include <variant>

namespace sslv {

/// Where everything is: a function of the options and the time alone, so that all cameras with the same
/// options agree and a test knows the truth. Distractors are under everything else.
class SimulatedWorld {
 public:
  /// Balls are hidden from `camera`, so worlds with hidden_balls are not the same for all cameras. Throws
  /// SettingsError when there is no room for all of them, or hidden_balls without a camera.
  SimulatedWorld(const SimulatorOptions& options, const FieldSize& field,
                 const std::array<double, 2>& robot_height_mm, const CameraModel* camera = nullptr);

  /// Everything's place at a Unix time. Orientations are in (-pi, pi]. In scatter, that in the slot's middle.
  SimulatedScene at(double t_s) const;

  /// The moments, evenly spread, of an exposure with its middle at t_s.
  void expose(double t_s, double exposure_s, std::span<SimulatedScene> moments) const;

  /// How everything moves from t_s on, and before, by no more than reach_s.
  SimulatorMotions motions_at(double t_s, double reach_s) const;

 private:
  std::variant<SimulatorPaths, SimulatorScatter> placement_;
};

}  // namespace sslv
