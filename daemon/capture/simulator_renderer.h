// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator_options.h"
#include "capture/simulator_picture.h"
#include "capture/simulator_world.h"
#include "geometry/camera_model.h"
#include "geometry/field.h"
#include "vision/patterns.h"

#include <array>
#include <span>
#include <vector>

#include <boost/container/static_vector.hpp>

namespace sslv {

/// Draws what the camera sees: carpet and lines, robots' tops with their patterns, balls. Every pixel goes
/// through the camera model by itself and is covered by edges exactly (the share of its square that lies
/// inside), so a drawn dot's centre is right within a hundredth of a pixel. The robots' sides are not drawn.
class SimulatorRenderer {
 public:
  static constexpr std::size_t kMaxMoments = 8;
  using Boxes =
      boost::container::static_vector<PixelBox, SimulatedScene::kMaxRobots + SimulatedScene::kMaxBalls>;

  /// `patterns` must have every id that will be drawn.
  SimulatorRenderer(const SimulatorOptions& options, const FieldSize& field, const CameraModel& camera,
                    const PatternTable& patterns);

  /// The field without robots and balls.
  LightPicture background() const;

  /// Draws robots and balls over `picture`, the average of the moments (of one world) when there are several
  /// (up to kMaxMoments), and names the boxes it drew in.
  void draw(std::span<const SimulatedScene> moments, LightPicture& picture, Boxes& boxes) const noexcept;

 private:
  struct Color {
    float r, g, b;
  };
  struct Footprint;  // how the field moves under one pixel
  struct Shape;      // where a thing is
  struct Coat;       // what of a pixel a thing covers, and with which light

  float light_at(int x, int y) const;
  Color carpet_at(const Eigen::Vector2d& field_mm) const;
  float lines_at(const Eigen::Vector2d& field_mm, const Footprint& footprint) const;
  Footprint footprint_at(const Eigen::Vector2d& pixel, double height_mm) const;
  PixelBox box_around(const Eigen::Vector3d& center_mm, double radius_mm) const;
  void draw_robot(std::span<const SimulatedScene> moments, std::size_t index, LightPicture& picture,
                  Boxes& boxes) const;
  void draw_ball(std::span<const SimulatedScene> moments, std::size_t index, LightPicture& picture,
                 Boxes& boxes) const;
  template <class CoatOf>
  void paint(const PixelBox& box, double height_mm, std::span<const Shape> shapes, const CoatOf& coat_of,
             LightPicture& picture) const;

  SimulatorOptions options_;
  FieldSize field_;
  std::vector<FieldLine> lines_;
  std::vector<FieldArc> arcs_;
  CameraModel camera_;
  PatternTable patterns_;
};

}  // namespace sslv
