// SPDX-License-Identifier: Apache-2.0
#include "lab/accuracy.h"

#include "base/error.h"
#include "support/paths.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <unistd.h>

namespace sslv::accuracy_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Accuracy : public ::testing::Test {
 protected:
  Accuracy() {
    suite_ = Json::parse(R"({
      "source": {"robots_yellow": 3, "robots_blue": 3, "balls": 1, "noise_sigma": 3},
      "must": {"recall": 0.9, "wrong_id": 0},
      "fields": {"small": {
        "size": {"field_length": 3000, "field_width": 2000},
        "calibration": {
          "focal_length": 460, "principal_point_x": 194.5, "principal_point_y": 144.5, "distortion": 0.05,
          "q0": 1, "q3": 0, "tz": 4000, "pixel_image_width": 390, "pixel_image_height": 290}}},
      "conditions": [{"name": "plain", "field": "small", "px_per_mm": 0.11}]
    })");
  }
  ~Accuracy() override { std::filesystem::remove(file_); }

  AccuracySuite read() const {
    std::ofstream(file_) << suite_;
    return read_accuracy_suite(file_);
  }
  std::string error() const {
    try {
      read();
    } catch (const SettingsError& error) {
      return error.what();
    }
    return "no error";
  }

  const std::string file_ = testing::TempDir() + "accuracy_test." + std::to_string(::getpid()) + ".json";
  Json suite_;
};

TEST_F(Accuracy, RunsAndTabulatesAConditionAndNamesWhatFails) {
  suite_["conditions"][0]["must"] = {{"position_rms_mm", 0.0001}, {"recall", nullptr}};
  const AccuracyReport report = run_accuracy_suite(read(), {{"plain"}, 2});
  ASSERT_EQ(report.rows.size(), 1U);
  const AccuracyRow& row = report.rows.front();
  EXPECT_EQ(row.condition, "plain");
  EXPECT_EQ(row.pixel_format, "uyvy");
  EXPECT_NEAR(row.px_per_mm, 0.11, 0.001);
  EXPECT_EQ(row.score.frames_compared, 2U);
  EXPECT_GE(row.score.robots.expected, 6U);
  EXPECT_GE(row.score.robots.recall(), 0.8);
  EXPECT_THAT(row.failures,
              ElementsAre(AllOf(StartsWith("position_rms_mm "), HasSubstr(" is above 0.0001"))));
  EXPECT_FALSE(report.passed());

  EXPECT_THAT(accuracy_text(report, false),
              AllOf(HasSubstr("\nplain      uyvy    clicked  0.110  "), HasSubstr("FAILED\n"),
                    HasSubstr("\nplain, uyvy, clicked: position_rms_mm ")));
  EXPECT_THAT(accuracy_text(report, true),
              AllOf(HasSubstr("\n| plain | uyvy | clicked | 0.110 | "), HasSubstr("\n|---|---|---|---:")));
  std::size_t detections = 0;
  for (const Reliability::Bin& bin : report.reliability.robots) {
    EXPECT_LE(bin.right, bin.count);
    detections += bin.count;
  }
  EXPECT_GE(detections, row.score.robots.found);
  const Json json = accuracy_json(report);
  EXPECT_EQ(json["passed"], false);
  EXPECT_EQ(json["rows"][0]["robots"]["expected"], row.score.robots.expected);
}

TEST_F(Accuracy, HallsShareTheFramesAndDiffer) {
  suite_["halls"] = {1, 2};
  suite_["source"]["hall"] = {{"kind", "usual"}};
  const AccuracyReport both = run_accuracy_suite(read(), {{}, 4});
  ASSERT_EQ(both.rows.size(), 1U);
  EXPECT_EQ(both.rows[0].score.frames_compared, 4U);
  suite_["conditions"][0]["halls"] = {2};
  const AccuracyReport second = run_accuracy_suite(read(), {{}, 2});
  suite_["conditions"][0]["halls"] = {1};
  const AccuracyReport first = run_accuracy_suite(read(), {{}, 2});
  EXPECT_EQ(first.rows[0].score.frames_compared, 2U);
  EXPECT_EQ(both.rows[0].score.robots.found,
            first.rows[0].score.robots.found + second.rows[0].score.robots.found);
  EXPECT_NE(first.rows[0].score.robot_position_mm.rms, second.rows[0].score.robot_position_mm.rms);
}

TEST_F(Accuracy, AHallWithoutLearntColoursIsAFailedRowWithAReason) {
  suite_["colors"] = "learnt";
  suite_["learn_frames"] = 1;
  suite_["halls"] = {3, 4};
  suite_["learn_source"] = {{"light", 0.05}, {"noise_sigma", 30}};  // too dark to tell colours apart
  suite_["conditions"].push_back(suite_["conditions"][0]);
  suite_["conditions"][1]["name"] = "seen in good light";
  suite_["conditions"][1]["learn_source"] = {{"light", 1}, {"noise_sigma", 3}};
  suite_["conditions"][1]["must"] = {{"recall", nullptr}, {"wrong_id", nullptr}};
  const AccuracyReport report = run_accuracy_suite(read(), {{}, 2});
  ASSERT_EQ(report.rows.size(), 2U);
  EXPECT_THAT(report.rows[0].failures,
              ElementsAre(StartsWith("not learnt in hall 3: "), StartsWith("not learnt in hall 4: "),
                          StartsWith("recall ")));
  EXPECT_EQ(report.rows[0].colors, AccuracyColors::kLearnt);
  EXPECT_EQ(report.rows[0].score.robots.found, 0U);
  EXPECT_GT(report.rows[1].score.robots.found, 0U);
}

TEST_F(Accuracy, InWeakLightTwelveBitsAreMoreExactThanEight) {
  Json& deep = suite_["conditions"][0];
  deep["pixel_formats"] = {"bayer_rg8"};
  deep["px_per_mm"] = 0.2;
  deep["source"] = {{"bits", 12}, {"light", 0.1}, {"noise_sigma", 0.15}};
  deep["must"] = {{"recall", 1}};
  suite_["conditions"].push_back(deep);
  suite_["conditions"][1]["name"] = "cut";
  suite_["conditions"][1]["cut_to_8_bits"] = true;
  const AccuracyReport report = run_accuracy_suite(read(), {{}, 12});
  ASSERT_EQ(report.rows.size(), 2U);
  EXPECT_TRUE(report.passed());
  EXPECT_LT(report.rows[0].score.robot_position_mm.rms, 0.92 * report.rows[1].score.robot_position_mm.rms);
}

TEST_F(Accuracy, CountsFalseBallsInAHundredPictures) {
  Score score;
  score.frames_compared = 40;
  score.balls.invented = 3;
  EXPECT_DOUBLE_EQ(false_balls_in_100(score), 7.5);
  EXPECT_DOUBLE_EQ(false_balls_in_100(Score()), 0);

  suite_["conditions"][0]["source"] = {{"distractors", 40}};
  suite_["conditions"][0]["stages"] = {{"detect_balls", {{"min_confidence", 0}}}};
  suite_["conditions"][0]["must"] = {{"recall", nullptr}, {"wrong_id", nullptr}, {"false_balls_in_100", 0}};
  const AccuracyReport report = run_accuracy_suite(read(), {{}, 4});
  EXPECT_THAT(report.rows[0].failures, ElementsAre(StartsWith("false_balls_in_100 ")));
}

TEST_F(Accuracy, PassesWithoutFailures) {
  AccuracyReport report;
  report.rows.push_back({"plain", "uyvy", AccuracyColors::kClicked, 0.2, {}, {}});
  EXPECT_TRUE(report.passed());
  EXPECT_THAT(accuracy_text(report, false), testing::Not(HasSubstr("FAILED")));
}

TEST_F(Accuracy, RefusesInvalidSuites) {
  const Json good = suite_;
  const auto error_with = [&](const char* pointer, const Json& value) {
    suite_ = good;
    suite_[Json::json_pointer(pointer)] = value;
    return error();
  };
  EXPECT_EQ(error(), "no error");
  EXPECT_EQ(error_with("/conditions/0/field", "large"),
            file_ + ": /conditions/0/field: no field \"large\"; known: small");
  EXPECT_THAT(error_with("/conditions/0/source", {{"nose_sigma", 3}}),
              StartsWith(file_ + ": /conditions/0/source/nose_sigma: no such parameter; known: "));
  EXPECT_EQ(error_with("/conditions/0/must", {{"recall", 2}}),
            file_ + ": /conditions/0/must/recall: 2 is not allowed; expected a number 0.0 .. 1.0");
  EXPECT_THAT(
      error_with("/conditions/0/pixel_formats", {"mono8"}),
      StartsWith(file_ + ": /conditions/0/pixel_formats/0: \"mono8\" is not allowed; expected a pixel "));
  EXPECT_THAT(error_with("/conditions/0/stages", {{"detect_robots", {{"speed", 1}}}}),
              StartsWith(file_ + ": /conditions/0/stages/detect_robots/speed: no such parameter"));
  EXPECT_THAT(error_with("/conditions/0/teams", {{"yellow", {{"robot_height", 1}}}}),
              StartsWith(file_ + ": /conditions/0/teams/yellow/robot_height: 1 is not allowed"));
  EXPECT_THAT(error_with("/conditions/0/name", ""), StartsWith(file_ + ": /conditions/0/name: "));
  EXPECT_THAT(error_with("/fields/small/calibration/q0", 0.5),
              StartsWith(file_ + ": /fields/small/calibration: q0..q3 has length 0.5"));
}

TEST_F(Accuracy, NamesTheConditionsThereAre) {
  try {
    run_accuracy_suite(read(), {{"plane"}, 1});
    FAIL() << "no error";
  } catch (const SettingsError& error) {
    EXPECT_STREQ(error.what(), "--only: the suite has no condition \"plane\"; known: plain");
  }
}

TEST(AccuracyGolden, TheSuiteOfTheProjectCanBeRead) {
  EXPECT_GT(read_accuracy_suite(source_path("/tests/golden/accuracy.json")).conditions.size(), 20U);
  EXPECT_GT(read_accuracy_suite(source_path("/tests/golden/halls.json")).conditions.size(), 20U);
}

}  // namespace
}  // namespace sslv::accuracy_test
