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

/// Finds robots that two cameras saw at the same moment, from the cameras' detections as they come. Cameras
/// need not take their images at once: between two images of one camera a robot goes straight on.
class TieCollector {
 public:
  /// Cameras are told apart by their place, 0 .. cameras - 1.
  explicit TieCollector(std::size_t cameras) : cameras_(cameras) {}

  /// The robots of a camera's next image.
  void add(std::size_t camera, double t_capture_s, std::span<const Robot> robots);

  std::size_t count() const { return ties_.size(); }
  /// Spread over where the cameras overlap, no more than the fit needs.
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
  std::map<Identity, std::vector<Track>> tracks_;  // one for each camera
  std::map<Cell, OverlapTie> ties_;                // the surest of each cell
};

}  // namespace sslv
