// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_age.h"

#include "settings/history.h"

namespace sslv {
namespace {

/// Reduces the settings' /field to the sizes of the painted lines.
Json painted(Json field) {
  for (const char* other : {"goal_depth", "goal_height", "goal_width", "boundary_width",
                            "boundary_width_goal_line", "goal_substitution_area_width", "ball_radius",
                            "max_robot_radius", "stack", "stages", "other_computers"})
    field.erase(other);
  return field;
}

}  // namespace

bool field_changed_since(double time_s, const Json& settings, const Json& steps) {
  Json then = settings;
  try {
    for (const Json& step : steps) {
      if (step.at("time").get<double>() <= time_s) break;
      then = then.patch(backward_patch(step.at("changes")));
    }
  } catch (const Json::exception&) {
    // The admin's file was edited in between, so older steps do not apply. Compare with the settings reached
    // so far.
  }
  return painted(then.at("field")) != painted(settings.at("field"));
}

}  // namespace sslv
