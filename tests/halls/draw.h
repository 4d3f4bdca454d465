// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "camera_bytes.h"
#include "hall.h"
#include "lamps.h"
#include "play.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sslv::halls {

/// Draws the frames of one hall in linear light, as received by its sensor.
class Painter {
 public:
  /// Draws everything static; takes about a second for large images.
  Painter(const Hall& hall, const CameraModel& camera);

  /// Nonzero in pixels where nothing may be placed: furniture, people, distractors, cables.
  const std::vector<std::uint8_t>& obstacles() const { return obstacles_; }

  /// `light`: brightness of this frame's lamps relative to the average.
  Picture frame(const Play& play, int number, double light);

 private:
  struct Box {
    int left, top, right, bottom;  // right and bottom are exclusive
    bool overlaps(const Box& o) const {
      return left < o.right && o.left < right && top < o.bottom && o.top < bottom;
    }
    bool contains(int x, int y) const { return x >= left && x < right && y >= top && y < bottom; }
  };
  Box box_around(const Sphere& sphere) const;
  void draw_floor();
  /// `travel_mm`: how far objects move away from their places during the frame.
  void draw_solids(std::span<const Solid* const> solids, const LightMap* light, Picture& picture,
                   std::vector<std::uint8_t>* covered, double travel_mm) const;
  void cast_shadow(const Eigen::Vector2d& at_mm, double radius_mm, double height_mm, Picture& picture) const;

  const Hall& hall_;
  const CameraModel& camera_;
  LightMap light_;
  Picture still_;  // under even light
  std::vector<std::uint8_t> obstacles_;
};

}  // namespace sslv::halls
