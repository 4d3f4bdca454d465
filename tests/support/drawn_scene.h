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
/// The same camera tilted by 30 degrees; its optical axis still meets the floor at (1250, 0).
CameraCalibration oblique_camera();
/// overhead_camera() with a wider lens: pixels are `times` larger.
CameraCalibration wide_camera(double times);

/// A camera without vignette, with images of overhead_camera()'s size.
SimulatorOptions plain_options(PixelFormat format = PixelFormat::kUyvy, double noise_sigma = 2);

/// The colour of a paint (a label, or one of paint::) in white light at brightness 1, as drawn by the
/// simulator.
Rgb paint_color(std::uint8_t paint);

/// An image of objects at given places, drawn like the simulator's, with a colour table from the prints' own
/// colours in the scene's light, and the detectors' results for it.
class DrawnScene {
 public:
  explicit DrawnScene(const SimulatorOptions& options = plain_options(),
                      const CameraCalibration& camera = overhead_camera(),
                      std::array<double, 2> robot_height_mm = {140, 140}, const FieldSize& field = {});

  /// `covered_dot`: a side dot drawn black like the top; -1: none.
  void add_robot(Team team, int id, double x_mm, double y_mm, double angle_rad, int covered_dot = -1);
  void add_ball(double x_mm, double y_mm);
  /// A flat object on the carpet, below all others.
  void add_thing(const SimulatedDistractor& thing);
  /// A disc at some height, above everything else, such as a hand or a bag. `color`: in white light.
  void cover(double x_mm, double y_mm, double z_mm, double radius_mm, Rgb color);
  /// The same, as a bar between two places.
  void cover_bar(double x1_mm, double y1_mm, double x2_mm, double y2_mm, double z_mm, double width_mm,
                 Rgb color);
  /// Removes everything.
  void clear();
  /// The next image shows the same scene with other noise.
  void expose_again() { image_ = {}; }

  const SimulatedScene& things() const { return things_; }
  /// The detectors' scene; a test may change it.
  Scene& scene() { return scene_; }
  void use_lut(std::shared_ptr<const Lut> lut);
  /// Draws and detects robots with patterns other than the league's. They must outlive the scene.
  void use_patterns(const PatternTable& patterns) { patterns_ = &patterns; }
  /// Also accepts regions of one cell.
  void use_single_cells();
  const Lut& lut() { return *lut_pointer(); }
  const std::shared_ptr<const Lut>& lut_pointer();
  /// Its buffer ends with the image's last byte, so that sanitizers detect reads beyond it.
  const Image& image();
  const RegionList& regions();

  /// Detected by new detectors without memory.
  RobotList robots(const DetectRobots::Params& params = {});
  BallList balls(const DetectBalls::Params& params = {});
  /// Detected by a detector that may have memory.
  RobotList robots_by(DetectRobots& detector, double t_s, const DetectRobots::Params& params = {});

 private:
  /// Painted over the finished image.
  struct Cover {
    std::function<bool(const Eigen::Vector2d& field_mm)> is_in;
    Eigen::Vector2d middle_mm;
    double z_mm, reach_mm;
    Rgb color;
  };
  void draw();
  void paint(const Cover& cover, LightPicture& picture) const;

  SimulatorOptions options_;
  const PatternTable* patterns_ = &league_patterns();
  Scene scene_;
  SimulatedScene things_;
  std::vector<Cover> covers_;
  SimulatorSensor sensor_;
  std::shared_ptr<const Lut> lut_;  // made on demand
  std::unique_ptr<std::uint8_t[]> bytes_;
  std::optional<Image> image_;
  Segment::Params segmentation_;
  std::optional<RegionList> regions_;
};

}  // namespace sslv
