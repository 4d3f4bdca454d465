// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/refine_jointly.h"
#include "vision/detections.h"

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace sslv {

/// Collects tie points from the cameras' detections: robots that two cameras saw at the same moment. Cameras
/// need not be synchronous: a robot's position is interpolated linearly between two images of a camera.
class TieCollector {
 public:
  /// Cameras are identified by index, 0 .. cameras - 1.
  explicit TieCollector(std::size_t cameras) : cameras_(cameras) {}

  /// Adds the robots of a camera's next image.
  void add(std::size_t camera, double t_capture_s, std::span<const Robot> robots);

  std::size_t count() const { return ties_.size(); }
  /// Returns tie points spread over the cameras' overlap, no more than the fit needs.
  std::vector<OverlapTie> ties() const;

 private:
  struct Seen {
    double t_s;
    Eigen::Vector2d pixel, place_mm;
    double height_mm;
  };
  struct Track {
    std::optional<Seen> before, newest;
  };
  using Identity = std::pair<Team, int>;
  /// Two cameras and a square of the field.
  using Cell = std::tuple<std::size_t, std::size_t, int, int>;

  void tie(std::size_t camera, const Seen& seen, std::size_t other_camera, const Track& other);

  std::size_t cameras_;
  std::map<Identity, std::vector<Track>> tracks_;  // one track for each camera
  std::map<Cell, OverlapTie> ties_;                // in each cell the tie point with the smallest sigma
};

}  // namespace sslv
