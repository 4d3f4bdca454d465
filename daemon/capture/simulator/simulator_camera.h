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

/// One simulated camera: the bytes of its image at any time, and the ground truth. The background is drawn
/// once; a frame redraws only the surroundings of moving things, then adds noise. Memory: at least 14 bytes
/// per pixel; 12 more if the light changes.
class SimulatedCamera {
 public:
  /// Uses the camera of context.scene. Throws CaptureError, in one line, if the calibration is missing or for
  /// another image size, if there are too many things for the field, or if an id has no pattern.
  SimulatedCamera(const SimulatorOptions& options, const SourceContext& context,
                  const PatternTable& patterns);

  /// The layout that draw() writes; its data is null.
  const ImageView& layout() const { return layout_; }
  std::size_t picture_bytes() const { return sensor_.picture_bytes(); }

  /// Writes the image whose exposure is centred at Unix time t_s. The noise differs in each call.
  void draw(double t_s, std::uint8_t* picture) noexcept;

  SimulatedScene scene_at(double t_s) const { return world_.at(t_s); }

  /// {"frame", "t", "robots": [{"team", "id", "x", "y", "orientation", "height", "covered_dot", "visible",
  /// "visible_share", "pixel_x", "pixel_y"}], "balls": [{"x", "y", "visible", "visible_share", "pixel_x",
  /// "pixel_y"}]} with the names and units of docs/openapi.json. "visible": the whole top of the robot, or
  /// the whole ball, is in the image, and no robot hides or nearly hides a part of it. "visible_share": the
  /// fraction of the top or ball that is in the image and not hidden; 1 only if "visible". "covered_dot": the
  /// side dot that is painted over (index in the pattern table), or null. Things out of sight are omitted.
  /// With a rolling shutter, x, y and orientation are given at t_s, but pixel_x, pixel_y and visibility at
  /// the time when the row that shows the thing's centre is exposed.
  Json truth(const std::string& frame, double t_s) const;

 private:
  /// The hall and the field: drawn once, and developed again when the light changes.
  struct Background {
    LightPicture light;
    std::vector<std::uint8_t> clean;  // image bytes without noise
    std::vector<float> blurred;       // light after the lens blur; empty if the light never changes
    std::array<float, 3> gains;       // gains used to develop `clean`
  };
  /// Equal to the background except while a frame is drawn.
  struct Canvas {
    LightPicture light;
    std::vector<std::uint8_t> clean;
    SimulatorRenderer::Boxes boxes;  // regions in which the frame was drawn
  };
  /// The world during a frame's exposure.
  struct Exposure {
    std::vector<SimulatedScene> moments;
    SimulatorMotions motions;  // only used with a rolling shutter
  };

  bool light_changes() const;
  void develop_background();
  void follow_light(double t_s);
  bool fully_visible(const Eigen::Vector3d& center_mm, double radius_mm, const SimulatedScene& scene) const;
  double visible_share(const Eigen::Vector3d& center_mm, double radius_mm, const SimulatedScene& scene,
                       const SimulatedRobot* top) const;

  SimulatorOptions options_;  // with `hall` resolved
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
