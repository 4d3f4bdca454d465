// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_age.h"

#include "settings/history.h"

#include <gtest/gtest.h>

namespace sslv::calibration_age_test {
namespace {

const Json kSettings{{"site", "A"}, {"field", {{"field_length", 9000}, {"goal_height", 160}}}};

Json changed(Json settings, const std::string& pointer, const Json& value) {
  settings[Json::json_pointer(pointer)] = value;
  return settings;
}

Json step(double time_s, const Json& before, const Json& after) {
  return {{"time", time_s}, {"changes", changes_between(before, after)}};
}

TEST(CalibrationAge, DetectsLaterFieldChanges) {
  const Json now = changed(kSettings, "/field/field_length", 12000);
  const Json steps = Json::array({step(20, kSettings, now)});
  EXPECT_TRUE(field_changed_since(10, now, steps));
  EXPECT_FALSE(field_changed_since(30, now, steps));
  EXPECT_FALSE(field_changed_since(10, now, Json::array()));
}

TEST(CalibrationAge, AcceptsAFieldThatWasChangedBack) {
  const Json between = changed(kSettings, "/field/field_length", 12000);
  const Json steps{step(30, between, kSettings), step(20, kSettings, between)};
  EXPECT_FALSE(field_changed_since(10, kSettings, steps));
  EXPECT_TRUE(field_changed_since(25, kSettings, steps));
}

TEST(CalibrationAge, LooksOnlyAtWhatIsPainted) {
  const Json now = changed(changed(changed(kSettings, "/field/goal_height", 200), "/site", "B"),
                           "/field/goal_substitution_area_width", 300);
  EXPECT_FALSE(field_changed_since(10, now, Json::array({step(20, kSettings, now)})));
  const Json other_stack = changed(kSettings, "/field/stack", Json::array());
  EXPECT_FALSE(field_changed_since(10, other_stack, Json::array({step(20, kSettings, other_stack)})));
}

TEST(CalibrationAge, StopsAtAStepThatDoesNotApply) {
  const Json now = changed(kSettings, "/field/field_length", 12000);
  const Json misfit{{"time", 15}, {"changes", {{{"op", "remove"}, {"path", "/gone/x"}, {"before", 1}}}}};
  EXPECT_TRUE(field_changed_since(10, now, Json{step(20, kSettings, now), misfit}));
}

}  // namespace
}  // namespace sslv::calibration_age_test
