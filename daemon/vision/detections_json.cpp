// SPDX-License-Identifier: Apache-2.0
#include "vision/detections_json.h"

#include "vision/label.h"
#include "vision/miss_text.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace sslv {

Json detections_json(const RobotList& robots, const BallList& balls) {
  Json out{{"robots", Json::array()}, {"balls", Json::array()}};
  for (const Robot& robot : robots.robots) {
    out["robots"].push_back({{"team", name_of(robot.team)},
                             {"id", robot.id},
                             {"x", robot.x_mm},
                             {"y", robot.y_mm},
                             {"orientation", robot.orientation_rad},
                             {"height", robot.height_mm},
                             {"confidence", robot.confidence},
                             {"pixel_x", robot.pixel_x},
                             {"pixel_y", robot.pixel_y}});
  }
  for (const Ball& ball : balls.balls) {
    out["balls"].push_back({{"x", ball.x_mm},
                            {"y", ball.y_mm},
                            {"confidence", ball.confidence},
                            {"area", ball.area_px},
                            {"pixel_x", ball.pixel_x},
                            {"pixel_y", ball.pixel_y}});
  }
  return out;
}

Json misses_json(const RobotList& robots) {
  Json out = Json::array();
  for (const RobotMiss& miss : robots.misses) {
    std::array<char, 128> text;
    out.push_back({{"pixel_x", miss.pixel_x},
                   {"pixel_y", miss.pixel_y},
                   {"radius", miss.radius_px},
                   {"text", std::string(text.data(), miss_text(miss, text))}});
  }
  return out;
}

Json truth_draft_json(const std::string& name, int width_px, int height_px, const RobotList& robots,
                      const BallList& balls) {
  Json line{{"frame", name}, {"checked", false}, {"width", width_px}, {"height", height_px}};
  line.update(detections_json(robots, balls));
  int number = 0;
  for (const char* kind : {"robots", "balls"}) {
    for (Json& thing : line[kind]) {
      thing.erase("confidence");
      thing.erase("area");
      thing.update({{"number", ++number}, {"by", "detector"}, {"visible_share", 1}});
    }
  }
  return line;
}

Json regions_json(const RegionList& list, const LabelSet& labels) {
  constexpr std::size_t kMax = 500;
  std::vector<const Region*> largest;
  for (const Region& region : list.regions) largest.push_back(&region);
  const std::size_t shown = std::min(kMax, largest.size());
  std::partial_sort(largest.begin(), largest.begin() + static_cast<std::ptrdiff_t>(shown), largest.end(),
                    [](const Region* a, const Region* b) { return a->area_px > b->area_px; });
  Json boxes = Json::array();
  for (std::size_t i = 0; i < shown; ++i) {
    const Region& region = *largest[i];
    boxes.push_back({region.label, region.left, region.top, region.right - region.left + 1,
                     region.bottom - region.top + 1, region.area_px});
  }
  Json names = Json::array();  // indexed by the label's value
  for (std::size_t value = 0; value <= labels.all().back().value; ++value)
    names.push_back(labels.name(static_cast<Label>(value)));
  return {{"labels", std::move(names)}, {"boxes", std::move(boxes)}, {"total", list.regions.size()}};
}

}  // namespace sslv
