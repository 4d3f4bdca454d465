// SPDX-License-Identifier: Apache-2.0
// ssl-visionlab calibrate on simulated images, called through ssl-visionctl.
#include "base/params_json.h"
#include "e2e/calibration_points.h"
#include "e2e/running_daemon.h"
#include "support/paths.h"

#include <fstream>

#include <gmock/gmock.h>

namespace sslv::test::calibrate_files_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class CalibrateFiles : public ::testing::Test {
 protected:
  Json json_in(const char* name) const { return Json::parse(std::ifstream(folder_.file(name))); }
  /// Images of camera 0 of the demo, with its robots.
  void simulate(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{lab_program(), "simulate", "--settings", source_path("/config/demo.json"),
                                   "--frames",    "5",        "--output",   folder_.file("frames")};
    words.insert(words.end(), more.begin(), more.end());
    const auto run = run_to_end(words);
    ASSERT_EQ(run.exit_code, 0) << run.output;
  }
  Finished calibrate(const std::vector<std::string>& more) const {
    std::vector<std::string> words{ctl_program(),          "calibrate", "--input",
                                   folder_.file("frames"), "--output",  folder_.file("calibration.json")};
    words.insert(words.end(), more.begin(), more.end());
    return run_to_end(words);
  }

  TemporaryFolder folder_;
  const Json truth_json_ =
      Json::parse(std::ifstream(source_path("/config/demo.json")))["cameras"][0]["calibration"];
  const CameraModel truth_{params_from_json<CameraCalibration>(truth_json_, "")};
};

TEST_F(CalibrateFiles, ClicksInAnyOrderBecomeTheCamera) {
  simulate();
  const std::string points = folder_.write("points.json", clicked_points(truth_).dump());
  const std::string previous = folder_.write("previous.json", truth_json_.dump());
  const auto run = calibrate({"--field", "division-b", "--points", points, "--height", "4000", "--previous",
                              previous, "--report", folder_.file("report.json")});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("good enough"), HasSubstr("expected errors"),
                                HasSubstr("since the previous"), Not(HasSubstr("looks wrong"))));
  // In the format of the settings, so that it can be pasted.
  const CameraModel found(params_from_json<CameraCalibration>(json_in("calibration.json"), ""));
  EXPECT_LT(worst_error_mm(truth_, found, 0), 1.5);
  EXPECT_LT(worst_error_mm(truth_, found, 150), 6);
  const Json report = json_in("report.json");
  EXPECT_EQ(report["calibration"], json_in("calibration.json"));
  EXPECT_EQ(report["lines_measured_to"], "middle");
  EXPECT_EQ(report["points"].size(), 6u);
  EXPECT_LT(report["moved_on_floor_mm"], 1.0);
}

TEST_F(CalibrateFiles, RawFramesAndTheFieldOfSettings) {
  simulate({"--raw"});
  const std::string points = folder_.write("points.json", Json{{"points", clicked_points(truth_)}}.dump());
  const auto run =
      calibrate({"--field", source_path("/config/demo.json"), "--points", points, "--pixel-format", "uyvy",
                 "--size", "780x580", "--lines", "middle", "--plus-x", "up", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(Json::parse(run.output)["accepted"], true);
}

TEST_F(CalibrateFiles, AnImageWithoutAFieldFailsWithAReport) {
  folder_.write("grey.ppm", "P6\n4 3\n255\n" + std::string(36, 'x'));
  const std::string points =
      folder_.write("points.json", R"([{"x":0,"y":0},{"x":3,"y":0},{"x":3,"y":2},{"x":0,"y":2}])");
  const auto run = run_to_end({ctl_program(), "calibrate", "--input", folder_.file("grey.ppm"), "--field",
                               "division-a", "--points", points, "--output", folder_.file("calibration.json"),
                               "--report", folder_.file("report.json")});
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("NOT calibrated"), HasSubstr("problem: ")));
  EXPECT_EQ(json_in("report.json")["found"], false);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("calibration.json")));
}

TEST_F(CalibrateFiles, WrongUseIsNamed) {
  simulate();
  const auto expect = [&](const std::vector<std::string>& words, int exit_code, const char* text) {
    const auto run = calibrate(words);
    EXPECT_EQ(run.exit_code, exit_code) << run.output;
    EXPECT_THAT(run.output, HasSubstr(text));
  };
  expect({"--field", "division-c"}, 78, "--field: \"division-c\" is not allowed");
  expect({"--field", "/no/such.json"}, 78, "/no/such.json");
  expect({"--field", "division-b", "--plus-x", "north"}, 64, "north");
  expect({"--field", "division-b", "--frames", "0"}, 64, "--frames");
  expect({"--field", "division-b", "--height", "3"}, 78, "/height_mm: 3.0 is not allowed");
  const std::string bad = folder_.write("bad.json", R"([{"x": 1}])");
  expect({"--field", "division-b", "--points", bad}, 78, "bad.json: /points/0/y: is missing");
  const std::string unknown = folder_.write(
      "unknown.json", R"([{"x":1,"y":1,"name":"moon"},{"x":2,"y":1},{"x":2,"y":2},{"x":1,"y":2}])");
  expect({"--field", "division-b", "--points", unknown}, 78, "moon");
  expect({}, 64, "--field");
}

}  // namespace
}  // namespace sslv::test::calibrate_files_test
