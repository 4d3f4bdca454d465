// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "capture/simulator/simulator_options.h"
#include "capture/simulator/simulator_picture.h"
#include "capture/simulator/simulator_renderer.h"
#include "capture/simulator/simulator_sensor.h"
#include "capture/simulator/simulator_world.h"
#include "capture/source.h"
#include "image/image.h"
#include "vision/patterns.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sslv {

/// One simulated camera: the bytes it gives at any time, and the truth about them. The field is drawn once; a
/// frame redraws only what lies around things, then adds noise. Memory: 14 bytes a pixel and more; 12 further
/// ones when its light changes.
class SimulatedCamera {
 public:
  /// The camera is that of context.scene. Throws CaptureError, in one line: no calibration, one for images
  /// of another size, too many things for the field, an id without a pattern.
  SimulatedCamera(const SimulatorOptions& options, const SourceContext& context,
                  const PatternTable& patterns);

  /// What draw() writes; data is null.
  const ImageView& layout() const { return layout_; }
  std::size_t picture_bytes() const { return sensor_.picture_bytes(); }

  /// Writes the image whose exposure has its middle at Unix time t_s. The noise is new each time.
  void draw(double t_s, std::uint8_t* picture) noexcept;

  SimulatedScene scene_at(double t_s) const { return world_.at(t_s); }

  /// {"frame", "t", "robots": [{"team", "id", "x", "y", "orientation", "height", "covered_dot", "visible",
  /// "visible_share", "pixel_x", "pixel_y"}], "balls": [{"x", "y", "visible", "visible_share", "pixel_x",
  /// "pixel_y"}]} with the names and units of docs/openapi.json. "visible": all of the robot's top, or of the
  /// ball, is in the image and not hidden by a robot, nor nearly so. "visible_share": how much of it is in
  /// the image and not hidden; 1 only for what is visible. "covered_dot": a side dot painted over (index in
  /// the pattern table), or null. Things out of sight are left out. With a rolling shutter x, y and
  /// orientation are those at t_s; pixel_x, pixel_y and what is visible are as its rows saw it.
  Json truth(const std::string& frame, double t_s) const;

 private:
  /// The hall and the field: drawn once, and developed again when the light changes.
  struct Background {
    LightPicture light;
    std::vector<std::uint8_t> clean;  // as bytes without noise
    std::vector<float> blurred;       // after the lens; empty when the light never changes
    std::array<float, 3> gains;       // that `clean` was developed with
  };
  /// The same as the background but while a frame is drawn.
  struct Canvas {
    LightPicture light;
    std::vector<std::uint8_t> clean;
    SimulatorRenderer::Boxes boxes;  // where it is drawn over
  };
  /// What a frame sees of the world.
  struct Exposure {
    std::vector<SimulatedScene> moments;
    SimulatorMotions motions;  // with a rolling shutter
  };

  bool light_changes() const;
  void develop_background();
  void follow_light(double t_s);
  bool fully_visible(const Eigen::Vector3d& center_mm, double radius_mm, const SimulatedScene& scene) const;
  double visible_share(const Eigen::Vector3d& center_mm, double radius_mm, const SimulatedScene& scene,
                       const SimulatedRobot* top) const;

  SimulatorOptions options_;  // with a hall that is resolved
  Scene scene_;
  SimulatedLamps lamps_;
  double banding_;
  SimulatedWorld world_;
  SimulatorRenderer renderer_;
  SimulatorSensor sensor_;
  ImageView layout_;
  Background background_;
  Canvas canvas_;
  Exposure exposure_;
};

}  // namespace sslv
