// SPDX-License-Identifier: Apache-2.0
#include "detections_json.h"

namespace sslv {

Json detections_json(const RobotList& robots, const BallList& balls) {
  Json out{{"robots", Json::array()}, {"balls", Json::array()}};
  for (const Robot& robot : robots.robots) {
    out["robots"].push_back({{"team", robot.team == Team::kBlue ? "blue" : "yellow"},
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

}  // namespace sslv
