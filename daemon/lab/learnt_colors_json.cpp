// SPDX-License-Identifier: Apache-2.0
#include "lab/learnt_colors_json.h"

#include "colors/margins_json.h"

namespace sslv {
Json learnt_colors_json(const LearntColors& learnt, const LabelSet& labels_known) {
  Json robots = Json::array(), balls = Json::array(), labels = Json::array();
  for (const LearntRobot& robot : learnt.robots) {
    Json dots = Json::array();
    for (const LearntRobot::Dot& dot : robot.dots) {
      dots.push_back({{"label", labels_known.name(dot.label)},
                      {"pixel_x", dot.pixel_x},
                      {"pixel_y", dot.pixel_y},
                      {"color", hex(dot.color)}});
    }
    robots.push_back({{"picture", robot.frame},
                      {"team", name_of(robot.team)},
                      {"id", robot.id < 0 ? Json() : Json(robot.id)},
                      {"pixel_x", robot.pixel_x},
                      {"pixel_y", robot.pixel_y},
                      {"orientation", robot.orientation_rad},
                      {"px_per_mm", robot.px_per_mm},
                      {"dots", dots}});
  }
  for (const LearntBall& ball : learnt.balls) {
    balls.push_back({{"picture", ball.frame},
                     {"pixel_x", ball.pixel_x},
                     {"pixel_y", ball.pixel_y},
                     {"radius_px", ball.radius_px},
                     {"color", hex(ball.color)}});
  }
  for (const LearntLabel& one : learnt.labels) {
    labels.push_back({{"label", labels_known.name(one.label)},
                      {"seen", one.seen},
                      {"guided", one.guided},
                      {"mean", hex(one.mean)},
                      {"spread", one.spread}});
  }
  return {{"learnt", learnt.problem.empty()},
          {"problem", learnt.problem},
          {"notes", learnt.notes},
          {"robots", robots},
          {"balls", balls},
          {"labels", labels},
          {"mm_per_px", learnt.mm_per_px},
          {"noise_grey", learnt.noise_grey},
          {"margins", margins_json(learnt.margins, labels_known)}};
}

}  // namespace sslv
