// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"
#include "vision/detections.h"
#include "vision/regions.h"

#include <tuple>

namespace sslv {

/// Finds balls: orange blobs of a ball's size and shape on the field that are not part of a robot.
class DetectBalls {
 public:
  struct Params {
    double min_area_ratio = 0.3;
    double max_area_ratio = 2.0;
    double max_aspect = 2.2;
    double max_outside_mm = 300;
    double robot_radius_mm = 45;
    int max_balls = 20;
    static constexpr auto fields() {
      return std::tuple{
          number("min_area_ratio", &Params::min_area_ratio, 0.0, 1.0, "",
                 "smallest ball, as a share of its true area"),
          number("max_area_ratio", &Params::max_area_ratio, 1.0, 20.0, "",
                 "largest ball, as a multiple of its true area"),
          number("max_aspect", &Params::max_aspect, 1.0, 10.0, "", "longest box, long side over short side"),
          number("max_outside_mm", &Params::max_outside_mm, 0.0, 10'000.0, "mm",
                 "how far outside the touch and goal lines a ball may lie"),
          number("robot_radius_mm", &Params::robot_radius_mm, 0.0, 200.0, "mm",
                 "an orange blob this near to a robot's centre is part of its pattern"),
          number("max_balls", &Params::max_balls, 1, 1'000, "", "report at most so many, the best ones"),
      };
    }
  };

  /// Without a calibrated camera the result is empty.
  void process(const Params& params, const Scene& scene, const RegionList& regions, const RobotList& robots,
               BallList& balls) noexcept;
};

}  // namespace sslv
