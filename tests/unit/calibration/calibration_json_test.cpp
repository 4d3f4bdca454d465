// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibration_json.h"

#include "base/params_json.h"

#include <limits>

#include <gmock/gmock.h>

namespace sslv::calibration_json_test {
namespace {

using testing::HasSubstr;
using testing::Optional;

std::string error_of(const std::string& json) {
  try {
    read_calibration_request(Json::parse(json));
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(CalibrationRequest, SurvivesARoundTrip) {
  const Json full = Json::parse(R"({
    "points": [{"x": 10.5, "y": 20.0, "name": "corner left top", "field_x": null, "field_y": null},
               {"x": 30.0, "y": 40.0, "name": "", "field_x": -500.0, "field_y": 0.0}],
    "frames": 3, "height_mm": 4000.0, "height_sigma_mm": 10.0, "focal_px": 600.0, "plus_x": "left",
    "lines_measured_to": "middle", "click_sigma_px": 2.0})");
  EXPECT_EQ(params_to_json(read_calibration_request(full)), full);
}

TEST(CalibrationRequest, ABareListIsThePoints) {
  const CalibrationRequest request = read_calibration_request(Json::parse(R"([{"x": 1, "y": 2}])"));
  ASSERT_EQ(request.points.size(), 1u);
  EXPECT_THAT(request.points[0].y, Optional(2.0));
  EXPECT_EQ(request.frames, 10);
}

TEST(CalibrationRequest, AnEmptyRequestForcesNothing) {
  const CalibrationTask task = make_task(read_calibration_request(Json::object()), FieldSize{}, {});
  EXPECT_TRUE(task.clicks.empty());
  EXPECT_EQ(task.plus_x, PlusX::kUnknown);
  EXPECT_EQ(task.measured, std::nullopt);
  EXPECT_EQ(task.height_mm, std::nullopt);
}

TEST(CalibrationRequest, BecomesTheEnginesTask) {
  const CalibrationTask task = make_task(
      read_calibration_request(Json::parse(
          R"({"points": [{"x": 1, "y": 2, "name": "a"}, {"x": 3, "y": 4, "field_x": 5, "field_y": 6}],
              "plus_x": "up", "lines_measured_to": "outer_edge", "height_mm": 4000})")),
      FieldSize{.field_length = 12000}, CameraCalibration{.focal_length = 700});
  EXPECT_EQ(task.field.field_length, 12000);
  ASSERT_EQ(task.clicks.size(), 2u);
  EXPECT_EQ(task.clicks[0].name, "a");
  EXPECT_FALSE(task.clicks[0].place_mm);
  EXPECT_EQ(task.clicks[1].pixel, Eigen::Vector2d(3, 4));
  EXPECT_EQ(task.clicks[1].place_mm, Eigen::Vector2d(5, 6));
  EXPECT_EQ(task.plus_x, PlusX::kUp);
  EXPECT_EQ(task.measured, LinesMeasured::kToOuterEdge);
  EXPECT_EQ(task.previous->focal_length, 700);
}

TEST(CalibrationRequest, ErrorsNameKeyValueAndWhatIsAllowed) {
  EXPECT_THAT(error_of(R"({"point": []})"), HasSubstr("/point: no such parameter; known: points, frames"));
  EXPECT_THAT(error_of(R"({"frames": 0})"), HasSubstr("/frames: 0 is not allowed; expected a whole number"));
  EXPECT_THAT(error_of(R"({"frames": 101})"), HasSubstr("1 .. 100"));
  EXPECT_THAT(error_of(R"({"plus_x": "north"})"), HasSubstr("/plus_x: \"north\" is not allowed"));
  EXPECT_THAT(error_of(R"({"points": [{"y": 2}]})"), HasSubstr("/points/0/x: is missing"));
  EXPECT_THAT(error_of(R"({"points": [{"x": 1, "y": null}]})"), HasSubstr("/points/0/y: is missing"));
  EXPECT_THAT(error_of(R"([{"x": 1, "y": 2, "field_x": 3}])"), HasSubstr("/points/0/field_y: is missing"));
  EXPECT_THAT(error_of(R"([{"x": 1, "y": 2, "z": 3}])"), HasSubstr("/points/0/z: no such parameter"));
  EXPECT_THAT(error_of(Json{{"points", Json(101, Json{{"x", 1}, {"y", 2}})}}.dump()),
              HasSubstr("/points: 101 entries are not allowed; expected at most 100"));
  EXPECT_THAT(error_of("7"), HasSubstr("expected an object"));
}

TEST(CalibrationReport, HoldsEveryFigureAndNullForNonFiniteOnes) {
  CalibrationReport report;
  report.found = report.accepted = true;
  report.calibration.focal_length = 601;
  report.camera.position_mm = {1, 2, 3};
  report.measured = LinesMeasured::kToOuterEdge;
  report.rms_px = 0.1;
  report.condition = std::numeric_limits<double>::infinity();
  report.moved_on_floor_mm = 4;
  report.moved_at_150_mm = std::numeric_limits<double>::quiet_NaN();
  report.line_figures = {{"HalfwayLine", 7, 8, 0.2, 0.3, 0.4}};
  report.click_figures = {{"corner left top", {10, 20}, {-4500, 3000}, 1.5, 6, true}};
  report.error_map = {{{100, 200}, 0.5, std::numeric_limits<double>::quiet_NaN()}};
  report.held = {"height"};
  report.notes = {"note"};
  report.problems = {"problem"};
  const Json json = report_json(report);
  EXPECT_EQ(json["accepted"], true);
  EXPECT_EQ(json["calibration"], params_to_json(report.calibration));
  EXPECT_EQ(json["camera"]["z_mm"], 3.0);
  EXPECT_EQ(json["lines_measured_to"], "outer_edge");
  EXPECT_EQ(json["rms_px"], 0.1);
  EXPECT_TRUE(json["condition"].is_null());
  EXPECT_EQ(json["moved_on_floor_mm"], 4.0);
  EXPECT_TRUE(json["moved_at_150_mm"].is_null());
  EXPECT_EQ(json["lines"], Json::parse(R"([{"name": "HalfwayLine", "patches": 7, "expected": 8,
                                            "rms_px": 0.2, "worst_px": 0.3, "rms_mm": 0.4}])"));
  EXPECT_EQ(json["points"], Json::parse(R"([{"name": "corner left top", "x": 10.0, "y": 20.0,
    "field_x": -4500.0, "field_y": 3000.0, "off_px": 1.5, "off_mm": 6.0, "suspect": true}])"));
  EXPECT_EQ(json["error_map"], Json::parse(R"([{"x_mm": 100.0, "y_mm": 200.0, "on_floor_mm": 0.5,
                                                "at_150_mm": null}])"));
  EXPECT_EQ(json["held"], Json{"height"});
  EXPECT_EQ(json["notes"], Json{"note"});
  EXPECT_EQ(json["problems"], Json{"problem"});
  EXPECT_EQ(figures_json(report)["rms_px"], 0.1);
}

TEST(CalibrationReport, WithoutACameraHasNone) {
  const Json json = report_json({});
  EXPECT_EQ(json["found"], false);
  EXPECT_TRUE(json["calibration"].is_null());
  EXPECT_TRUE(json["camera"].is_null());
  EXPECT_TRUE(json["moved_on_floor_mm"].is_null());
}

TEST(NamedPoints, LieInTheMiddleOfThePaint) {
  const auto corner = [](LinesMeasured measured) {
    const Json points = named_points_json(FieldSize{}, measured);
    const auto found = std::find_if(points.begin(), points.end(),
                                    [](const Json& p) { return p["name"] == "corner left top"; });
    return found == points.end() ? points : *found;
  };
  EXPECT_EQ(corner(LinesMeasured::kToMiddle),
            (Json{{"name", "corner left top"}, {"field_x", -4500.0}, {"field_y", 3000.0}}));
  EXPECT_EQ(corner(LinesMeasured::kToOuterEdge),
            (Json{{"name", "corner left top"}, {"field_x", -4495.0}, {"field_y", 2995.0}}));
}

}  // namespace
}  // namespace sslv::calibration_json_test
