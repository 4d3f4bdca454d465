// SPDX-License-Identifier: Apache-2.0
// TABLES stage name -> type. To add a stage: a class in vision/ (of the field: in tracking/), a row here
// (docs/extending.md).
#include "config/stages.h"

#include "pipeline/publish.h"
#include "tracking/agreement.h"
#include "tracking/clocks.h"
#include "tracking/gather.h"
#include "tracking/track.h"
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"
#include "vision/find_regions.h"
#include "vision/find_runs.h"
#include "vision/segment.h"
#include "vision/threshold.h"

namespace sslv {

std::span<const StageType> stage_table() {
  static const std::vector kStages{
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

std::span<const FieldStageType> field_stage_table() {
  static const std::vector kStages{
      field_stage<Gather>("gather", "takes what a camera saw, once it makes sense"),
      field_stage<Clocks>("clocks", "says when an image was really taken"),
      field_stage<Agreement>("agreement", "learns what cameras differ by, and takes it off"),
      field_stage<Track>("track", "follows robots and balls, and says where they are now"),
      field_stage<PublishField>("publish", "sends the tracks, and shows them in the panel"),
  };
  return kStages;
}

std::vector<std::string> default_field_stack() {
  return {"gather", "clocks", "agreement", "track", "publish"};
}

}  // namespace sslv
