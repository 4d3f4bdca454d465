// SPDX-License-Identifier: Apache-2.0
#include "lab/truth.h"

#include "base/error.h"
#include "lab/annotation_page.h"
#include "lab/score.h"

#include <cmath>
#include <sstream>

#include <gmock/gmock.h>

namespace sslv::truth_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// A camera that looks down from 4 m: 4 mm per pixel on the floor; +x is right and +y is up in the image.
Scene scene_from_above() {
  CameraCalibration c;
  c.focal_length = 1000;
  c.principal_point_x = 320;
  c.principal_point_y = 240;
  c.q0 = 1;
  c.q3 = 0;
  c.tz = 4000;
  c.pixel_image_width = 640;
  c.pixel_image_height = 480;
  Scene scene;
  scene.camera.emplace(c);
  return scene;
}

/// The draft of an image with yellow 3, blue 5 and a ball: marks 1 to 3.
Json draft() {
  Frame frame;
  const std::uint8_t nothing = 0;
  frame.image = Image({&nothing, 640, 480, 640, PixelFormat::kMono8}, nullptr, nullptr, nullptr);
  frame.robots.robots = {{Team::kYellow, 3, 0, 0, 0.5, 140, 320, 240, 0.99},
                         {Team::kBlue, 5, 400, 0, 0, 140, 424, 240, 0.9}};
  frame.balls.balls = {{100, 200, 345, 190, 30, 0.8}};
  return draft_of_truth("hall", frame);
}

Json corrected(const Corrections& corrections) {
  Json line = draft();
  correct(line, corrections, scene_from_above());
  return line;
}
std::string refusal(const Corrections& corrections) {
  Json line = draft();
  try {
    correct(line, corrections, scene_from_above());
  } catch (const SettingsError& error) {
    EXPECT_EQ(line, draft());  // unchanged
    return error.what();
  }
  return "no error";
}
/// Scores one line against another.
Score scored(const Json& detections, const Json& truth) {
  std::istringstream d(detections.dump()), t(truth.dump());
  return score(d, t);
}

TEST(Truth, ADraftIsWhatWasFoundAndNotCheckedYet) {
  const Json line = draft();
  EXPECT_EQ(line["checked"], false);
  const Score score = scored(line, line);
  EXPECT_EQ(score.robots.found, 2U);
  EXPECT_EQ(score.balls.found, 1U);
  EXPECT_THAT(score.frames_not_checked, testing::ElementsAre("hall"));
  EXPECT_THAT(score_text(score), HasSubstr("1 frames without a person's look at their truth: hall\n"));
  EXPECT_THAT(truth_text(line), AllOf(HasSubstr("hall: 2 robots, 1 balls, not checked yet\n"),
                                      HasSubstr("  1  yellow 3 "), HasSubstr("  3  ball ")));
}

TEST(Truth, RemovedMarksDoNotRenumberOthers) {
  const Json line = corrected({.remove = {1}});
  ASSERT_EQ(line["robots"].size(), 1U);
  EXPECT_EQ(line["robots"][0]["number"], 2);
  EXPECT_EQ(scored(draft(), line).robots.invented, 1U);
}

TEST(Truth, DoubtfulMarksMayBeFoundOrNot) {
  const Json line = corrected({.doubtful = {2, 3}});
  Json without = draft();
  without["robots"].erase(1);
  without["balls"].clear();
  for (const Json& detections : {draft(), without}) {
    const Score score = scored(detections, line);
    EXPECT_EQ(score.robots.expected, 1U);
    EXPECT_EQ(score.robots.invented + score.balls.invented + score.balls.expected, 0U);
  }
}

TEST(Truth, AWrongIdIsPutRight) {
  const Json line = corrected({.ids = {{2, 6}}});
  EXPECT_EQ(line["robots"][1]["id"], 6);
  EXPECT_EQ(scored(draft(), line).robots.wrong_id, 1U);
}

TEST(Truth, TwoRobotsMayChangeTheirIds) {
  const Json line = corrected({.ids = {{1, 4}, {2, 3}}, .robots = {{Team::kYellow, 3, 100, 100, 120, 100}}});
  EXPECT_EQ(line["robots"][0]["id"], 4);  // still yellow, like the new robot with its old id
  EXPECT_EQ(line["robots"][2]["id"], 3);
}

TEST(Truth, MissedThingsAreAddedByTheirPixels) {
  const Json line =
      corrected({.robots = {{Team::kBlue, 0, 220, 140, 220, 100}}, .balls = {{420, 240}}, .checked = true});
  ASSERT_EQ(line["robots"].size(), 3U);
  const Json& robot = line["robots"][2];
  EXPECT_EQ(robot["number"], 4);
  EXPECT_EQ(robot["by"], "hand");
  EXPECT_NEAR(robot["x"], -100 * 3.86, 1e-6);  // 4000 - 140 mm below the camera
  EXPECT_NEAR(robot["y"], 100 * 3.86, 1e-6);
  EXPECT_NEAR(robot["orientation"], M_PI / 2, 1e-9);  // up in the image
  EXPECT_NEAR(line["balls"][1]["x"], 100 * (4 - 0.0215), 1e-6);
  EXPECT_EQ(line["balls"][1]["number"], 5);
  EXPECT_EQ(line["checked"], true);
  const Score score = scored(draft(), line);
  EXPECT_EQ(score.robots.expected - score.robots.found, 1U);
  EXPECT_TRUE(score.frames_not_checked.empty());
}

TEST(Truth, InvalidCorrectionsAreRefused) {
  EXPECT_EQ(refusal({.remove = {9}}), "image hall: has no mark 9; it has 1, 2, 3");
  EXPECT_EQ(refusal({.ids = {{3, 1}}}), "image hall: mark 3 is a ball and has no id");
  EXPECT_EQ(refusal({.balls = {{640, 10}}}), "image hall: 640, 10 is not in it; it has 640x480 pixels");
  EXPECT_THAT(refusal({.robots = {{Team::kBlue, 5, 100, 100, 120, 100}}}),
              HasSubstr("blue 5 is there twice"));
  EXPECT_THAT(refusal({.robots = {{Team::kBlue, 1, 100, 100, 100, 100}}}), HasSubstr("looks towards"));
  // If one correction is refused, none is applied.
  EXPECT_THAT(refusal({.remove = {1}, .balls = {{-5, 0}}}), HasSubstr("-5, 0 is not in it"));
}

TEST(AnnotationPage, HoldsThePictureAndEveryMark) {
  const std::vector<std::uint8_t> jpeg{0xff, 0xd8, 0xff};
  Json line = draft();
  line["frame"] = "</script>";
  const std::string page = annotation_page(line, jpeg, scene_from_above(),
                                           {"ssl-visionlab annotate --truth t.jsonl", "a.html", ""});
  EXPECT_THAT(page, AllOf(HasSubstr("data:image/jpeg;base64,/9j/"), HasSubstr("\"yellow 3\""),
                          HasSubstr("\"blue 5\""), HasSubstr("--truth t.jsonl"), HasSubstr("\"a.html\""),
                          HasSubstr("\\u003c/script>\""), Not(HasSubstr("\"</script>"))));
}

}  // namespace
}  // namespace sslv::truth_test
