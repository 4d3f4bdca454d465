// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_options.h"
#include "capture/simulator/simulator_sensor.h"
#include "capture/simulator/simulator_world.h"
#include "geometry/scene.h"
#include "image/color.h"
#include "image/image.h"
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"
#include "vision/regions.h"
#include "vision/segment.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace sslv {

/// 780 x 580 pixels of 6 mm, straight down on (1250, 0).
CameraCalibration overhead_camera();
/// The same, tilted by 30 degrees: its optical axis meets the floor there.
CameraCalibration oblique_camera();
/// overhead_camera() with a wider lens: a pixel is as many times larger.
CameraCalibration wide_camera(double times);

/// A camera without vignette. Its pictures are as large as overhead_camera()'s.
SimulatorOptions plain_options(PixelFormat format = PixelFormat::kUyvy, double noise_sigma = 2);

/// A print's colour (a label, or one of paint::) in white light at brightness 1, as the simulator paints it.
Rgb paint_color(std::uint8_t paint);

/// A picture of things at places that a test names, drawn as the simulator draws them, with a colour table
/// from the prints' own colours in the scene's light, and what the detectors find in it.
class DrawnScene {
 public:
  explicit DrawnScene(const SimulatorOptions& options = plain_options(),
                      const CameraCalibration& camera = overhead_camera(),
                      std::array<double, 2> robot_height_mm = {140, 140}, const FieldSize& field = {});

  /// `covered_dot` is a side dot as black as the top; none: -1.
  void add_robot(Team team, int id, double x_mm, double y_mm, double angle_rad, int covered_dot = -1);
  void add_ball(double x_mm, double y_mm);
  /// A flat thing on the carpet, below all others.
  void add_thing(const SimulatedDistractor& thing);
  /// A disc at some height, over all else: a hand, a bag. `color` is what it shows in white light.
  void cover(double x_mm, double y_mm, double z_mm, double radius_mm, Rgb color);
  /// The same, a bar between two places.
  void cover_bar(double x1_mm, double y1_mm, double x2_mm, double y2_mm, double z_mm, double width_mm,
                 Rgb color);
  /// Takes all away again.
  void clear();
  /// Another picture of the same, with other noise.
  void expose_again() { image_ = {}; }

  const SimulatedScene& things() const { return things_; }
  /// What the detectors are told; a test may change it.
  Scene& scene() { return scene_; }
  void use_lut(std::shared_ptr<const Lut> lut);
  /// Regions of one cell count, too.
  void use_single_cells();
  const Lut& lut() { return *lut_pointer(); }
  const std::shared_ptr<const Lut>& lut_pointer();
  /// Its buffer ends with the picture's last byte, so that a sanitizer sees who reads beyond.
  const Image& image();
  const RegionList& regions();

  /// Found by new detectors, which remember nothing.
  RobotList robots(const DetectRobots::Params& params = {});
  BallList balls(const DetectBalls::Params& params = {});
  /// Found by one that may remember.
  RobotList robots_by(DetectRobots& detector, double t_s, const DetectRobots::Params& params = {});

 private:
  /// What is painted over a finished picture.
  struct Cover {
    std::function<bool(const Eigen::Vector2d& field_mm)> is_in;
    Eigen::Vector2d middle_mm;
    double z_mm, reach_mm;
    Rgb color;
  };
  void draw();
  void paint(const Cover& cover, LightPicture& picture) const;

  SimulatorOptions options_;
  Scene scene_;
  SimulatedScene things_;
  std::vector<Cover> covers_;
  SimulatorSensor sensor_;
  std::shared_ptr<const Lut> lut_;  // made when it is needed
  std::unique_ptr<std::uint8_t[]> bytes_;
  std::optional<Image> image_;
  Segment::Params segmentation_;
  std::optional<RegionList> regions_;
};

}  // namespace sslv
