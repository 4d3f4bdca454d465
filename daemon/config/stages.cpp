// SPDX-License-Identifier: Apache-2.0
// TABLES stage name -> type. To add a stage: a class in vision/ (of the field: in tracking/), a row here
// (docs/extending.md).
#include "config/stages.h"

#include "base/error.h"
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

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

std::vector<StageType> camera_stages() {
  return {
      stage<Segment>("segment",
                     "finds the regions of labelled pixels: threshold, find_runs and find_regions in one"),
      stage<Threshold>("threshold", "labels every pixel by the colour lookup table"),
      stage<FindRuns>("find_runs", "run-length encodes the labelled image"),
      stage<FindRegions>("find_regions", "joins runs into regions"),
      stage<DetectRobots>("detect_robots", "finds robots by the pattern table"),
      stage<DetectBalls>("detect_balls", "finds balls"),
      stage<Publish>("publish", "sends the detections"),
  };
}

std::vector<FieldStageType> field_stages() {
  return {
      field_stage<Gather>("gather", "takes what a camera saw, once it makes sense"),
      field_stage<Clocks>("clocks", "says when an image was really taken"),
      field_stage<Agreement>("agreement", "learns what cameras differ by, and takes it off"),
      field_stage<Track>("track", "follows robots and balls, and says where they are now"),
      field_stage<PublishField>("publish", "sends the tracks, and shows them in the panel"),
  };
}

struct Tables {
  std::vector<StageType> camera = camera_stages();
  std::vector<FieldStageType> field = field_stages();
  std::atomic<bool> is_used{false};  // nothing is added any more
};

Tables& tables() {
  static Tables tables;
  return tables;
}

const Tables& tables_in_use() {
  Tables& all = tables();
  all.is_used.store(true, std::memory_order_relaxed);
  return all;
}

template <class Type>
std::vector<Type> with(std::vector<Type> table, std::vector<Type> more) {
  for (Type& type : more) {
    if (std::ranges::find(table, type.name, &Type::name) != table.end()) {
      throw SettingsError(fmt::format("{}stage '{}': there is one of this name already",
                                      type.library.empty() ? "" : type.library + ": ", shortened(type.name)));
    }
    table.push_back(std::move(type));
  }
  return table;
}

}  // namespace

std::span<const StageType> stage_table() {
  return tables_in_use().camera;
}

std::span<const FieldStageType> field_stage_table() {
  return tables_in_use().field;
}

void add_stages(std::vector<StageType> camera, std::vector<FieldStageType> field) {
  Tables& all = tables();
  if (all.is_used.load(std::memory_order_relaxed)) throw std::logic_error("stages are added too late");
  auto cameras = with(all.camera, std::move(camera));
  all.field = with(all.field, std::move(field));
  all.camera = std::move(cameras);
  all.is_used.store(true, std::memory_order_relaxed);
}

std::vector<std::string> default_stack() {
  return {"segment", "detect_robots", "detect_balls", "publish"};
}

std::vector<std::string> default_field_stack() {
  return {"gather", "clocks", "agreement", "track", "publish"};
}

}  // namespace sslv
