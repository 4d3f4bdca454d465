// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_carpet.h"
#include "capture/simulator/simulator_lamps.h"
#include "capture/simulator/simulator_options.h"
#include "capture/simulator/simulator_paint.h"
#include "capture/simulator/simulator_picture.h"
#include "capture/simulator/simulator_prints.h"
#include "capture/simulator/simulator_surroundings.h"
#include "capture/simulator/simulator_world.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"
#include "vision/patterns.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <boost/container/static_vector.hpp>

namespace sslv {

/// Draws what the camera sees: carpet and lines, surroundings, distractors, balls, and robots as dark upright
/// prisms with their patterns on top. Each pixel is unprojected by the camera model, and its coverage by
/// edges is exact (the fraction of its square that lies inside), so a drawn dot's centre is accurate to a
/// hundredth of a pixel.
class SimulatorRenderer {
 public:
  static constexpr std::size_t kMaxMoments = 8;
  using Boxes = boost::container::static_vector<DrawnBox, 2 * SimulatedScene::kMaxRobots +
                                                              3 * SimulatedScene::kMaxBalls +
                                                              SimulatedScene::kMaxDistractors>;

  /// `patterns` must contain every id that will be drawn.
  SimulatorRenderer(const SimulatorOptions& options, const FieldSize& field, const CameraModel& camera,
                    const PatternTable& patterns);

  /// Draws the hall, the field and the scene's distractors, but no robots and balls.
  LightPicture background(const SimulatedScene& scene) const;

  /// Draws robots and balls over `picture`, and distractors unless they are static and so already in the
  /// background. Several moments of one world (up to kMaxMoments) are averaged. Sets `boxes` to the regions
  /// that were drawn. With `motions`, which rolling_shutter_ms requires, each row shows things at its own
  /// read-out time.
  void draw(std::span<const SimulatedScene> moments, LightPicture& picture, Boxes& boxes,
            const SimulatorMotions* motions = nullptr) const noexcept;

  /// Read-out time of a row, in s relative to the image's time.
  double row_delay_s(double y) const;

 private:
  struct Footprint;  // change of the field position over one pixel
  struct Shape;      // position and orientation of a thing
  struct Coat;       // coverage of a pixel by a thing, and its light
  struct Spot;       // the pixels that may show a flat disc

  /// The lamps' light on the floor, sampled on a grid of pixels because it changes slowly.
  class LampGrid {
   public:
    LampGrid(const SimulatedLamps& lamps, const CameraModel& camera, int width, int height);
    /// Factors on red, green and blue.
    Paint at(int x, int y) const;

   private:
    std::vector<Paint> lights_;  // row by row; empty: 1 everywhere
    int columns_ = 0;
  };
  struct Markings {
    explicit Markings(const FieldSize& painted) : lines(field_lines(painted)), arcs(field_arcs(painted)) {}
    std::vector<FieldLine> lines;
    std::vector<FieldArc> arcs;
  };

  float light_at(int x, int y) const;
  Paint floor_at(const Eigen::Vector2d& field_mm, const Footprint& footprint) const;
  std::optional<Paint> boards_at(int x, int y, const Paint& floor) const;
  float lines_at(const Eigen::Vector2d& field_mm, const Footprint& footprint) const;
  Footprint footprint_at(const Eigen::Vector2d& pixel, double height_mm) const;
  Spot spot_of(const Eigen::Vector3d& center_mm, double radius_mm) const;
  DrawnBox box_of(const Eigen::Vector3d& center_mm, double radius_mm, const SimulatorMotion* motion) const;
  DrawnBox in_picture(const DrawnBox& box) const;
  DrawnBox draw_distractor(const SimulatedDistractor& distractor, LightPicture& picture) const;
  void draw_slice(const SimulatedSurroundings::Slice& slice, LightPicture& picture) const;
  void draw_robot(std::span<const SimulatedScene> moments, std::size_t index, const SimulatorMotion* motion,
                  LightPicture& picture, Boxes& boxes) const;
  template <class List>
  void draw_soft_shadow(std::span<const SimulatedScene> moments, List SimulatedScene::*list,
                        std::size_t index, const SimulatorMotion* motion, double radius_mm, double height_mm,
                        LightPicture& picture, Boxes& boxes) const;
  void draw_shadow(std::span<const SimulatedScene> moments, std::size_t index, const SimulatorMotion* motion,
                   float gloss, LightPicture& picture, Boxes& boxes) const;
  void draw_ball(std::span<const SimulatedScene> moments, std::size_t index, const SimulatorMotion* motion,
                 LightPicture& picture, Boxes& boxes) const;
  template <class CoatOf, class MayShow>
  void paint(const DrawnBox& box, double height_mm, std::span<const Shape> shapes, const CoatOf& coat_of,
             const MayShow& may_show, LightPicture& picture, const SimulatorMotion* motion = nullptr) const;

  SimulatorOptions options_;
  FieldSize field_;
  Markings markings_;
  CameraModel camera_;
  PatternTable patterns_;
  SimulatedLamps lamps_;
  SimulatedCarpet carpet_;
  SimulatedSurroundings surroundings_;
  SimulatedPrints prints_;
  float shadows_;
  LampGrid lamp_grid_;
};

}  // namespace sslv
