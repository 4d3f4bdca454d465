// SPDX-License-Identifier: Apache-2.0
// TABLE stage name -> type. To add a stage: a class in vision/, a row here (docs/extending.md).
#include "config/stages.h"

#include "pipeline/publish.h"
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"
#include "vision/find_regions.h"
#include "vision/find_runs.h"
#include "vision/segment.h"
#include "vision/threshold.h"

#include <array>

namespace sslv {

std::span<const StageType> stage_table() {
  static const std::array kStages{
      stage<Segment>("segment",
                     "finds the regions of labelled pixels: threshold, find_runs and find_regions in one"),
      stage<Threshold>("threshold", "labels every pixel by the colour lookup table"),
      stage<FindRuns>("find_runs", "run-length encodes the labelled image"),
      stage<FindRegions>("find_regions", "joins runs into regions"),
      stage<DetectRobots>("detect_robots", "finds robots by the pattern table"),
      stage<DetectBalls>("detect_balls", "finds balls"),
      stage<Publish>("publish", "sends the detections"),
  };
  return kStages;
}

std::vector<std::string> default_stack() {
  return {"segment", "detect_robots", "detect_balls", "publish"};
}

}  // namespace sslv
