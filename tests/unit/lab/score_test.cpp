// SPDX-License-Identifier: Apache-2.0
#include "lab/score.h"

#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include <gmock/gmock.h>

namespace sslv::score_test {
namespace {

std::string robot(const char* team, int id, double x, double y, double orientation, bool visible = true) {
  return Json{{"team", team},      {"id", id}, {"x", x}, {"y", y}, {"orientation", orientation},
              {"visible", visible}}
      .dump();
}
std::string ball(double x, double y, bool visible = true) {
  return Json{{"x", x}, {"y", y}, {"visible", visible}}.dump();
}
std::string frame(const char* name, const std::string& robots, const std::string& balls) {
  return std::string(R"({"frame":")") + name + R"(","robots":[)" + robots + R"(],"balls":[)" + balls + "]}\n";
}
Score scored(const std::string& detections, const std::string& truth) {
  std::istringstream d(detections), t(truth);
  return score(d, t);
}

TEST(Score, MeasuresErrorsOfWhatWasFound) {
  const Score s =
      scored(frame("a", robot("blue", 1, 3, 4, 0.1) + "," + robot("yellow", 1, 1000, 0, 0), ball(500, 12)),
             frame("a", robot("blue", 1, 0, 0, 0) + "," + robot("yellow", 1, 1000, 1, 0), ball(500, 0)));
  EXPECT_EQ(s.frames_compared, 1U);
  EXPECT_EQ(s.robots.expected, 2U);
  EXPECT_EQ(s.robots.found, 2U);
  EXPECT_EQ(s.robots.recall(), 1);
  EXPECT_EQ(s.robots.precision(), 1);
  EXPECT_EQ(s.robot_position_mm.count, 2U);
  EXPECT_DOUBLE_EQ(s.robot_position_mm.mean, 3);
  EXPECT_DOUBLE_EQ(s.robot_position_mm.rms, std::sqrt(13));
  EXPECT_DOUBLE_EQ(s.robot_position_mm.p95, 5);
  EXPECT_DOUBLE_EQ(s.robot_position_mm.max, 5);
  EXPECT_NEAR(s.robot_orientation_deg.max, 0.1 * 180 / 3.14159265358979, 1e-9);
  EXPECT_NEAR(s.robot_orientation_deg.mean, 0.05 * 180 / 3.14159265358979, 1e-9);
  EXPECT_DOUBLE_EQ(s.ball_position_mm.rms, 12);
}

TEST(Score, P95LeavesOutTheWorstTwentieth) {
  std::string detections, truth;
  for (int i = 1; i <= 40; ++i) {
    const std::string name = std::to_string(i);
    detections += frame(name.c_str(), "", ball(i, 0));
    truth += frame(name.c_str(), "", ball(0, 0));
  }
  EXPECT_DOUBLE_EQ(scored(detections, truth).ball_position_mm.p95, 38);
}

TEST(Score, OrientationsWrapAtHalfATurn) {
  const Score s =
      scored(frame("a", robot("blue", 1, 0, 0, 3.13), ""), frame("a", robot("blue", 1, 0, 0, -3.13), ""));
  EXPECT_NEAR(s.robot_orientation_deg.rms, (2 * 3.14159265358979 - 6.26) * 180 / 3.14159265358979, 1e-9);
}

TEST(Score, AWrongIdIsNeitherFoundNorInvented) {
  const Score s =
      scored(frame("a", robot("blue", 2, 1, 0, 0), ""), frame("a", robot("blue", 1, 0, 0, 0), ""));
  EXPECT_EQ(s.robots.wrong_id, 1U);
  EXPECT_EQ(s.robots.found, 0U);
  EXPECT_EQ(s.robots.invented, 0U);
  EXPECT_EQ(s.robots.recall(), 0);
  EXPECT_EQ(s.robots.precision(), 0);
  EXPECT_EQ(s.robot_position_mm.count, 0U);
}

TEST(Score, AnotherTeamOrPlaceIsMissedAndInvented) {
  const Score s = scored(frame("a", robot("yellow", 1, 0, 0, 0) + "," + robot("blue", 5, 1101, 0, 0), ""),
                         frame("a", robot("blue", 1, 0, 0, 0) + "," + robot("blue", 5, 1000, 0, 0), ""));
  EXPECT_EQ(s.robots.found, 0U);
  EXPECT_EQ(s.robots.invented, 2U);
  EXPECT_EQ(s.robots.expected, 2U);
}

TEST(Score, CountsMissingRobotsAndInventedBalls) {
  const Score s =
      scored(frame("a", robot("blue", 1, 0, 0, 0), ball(0, 0) + "," + ball(900, 900)),
             frame("a", robot("blue", 1, 0, 0, 0) + "," + robot("blue", 2, 500, 0, 0), ball(1, 0)));
  EXPECT_EQ(s.robots.recall(), 0.5);
  EXPECT_EQ(s.robots.precision(), 1);
  EXPECT_EQ(s.balls.recall(), 1);
  EXPECT_EQ(s.balls.precision(), 0.5);
  EXPECT_EQ(s.balls.invented, 1U);
}

TEST(Score, ATrueThingIsFoundOnce) {
  const Score s = scored(frame("a", robot("blue", 1, 60, 0, 0) + "," + robot("blue", 1, 10, 0, 0), ""),
                         frame("a", robot("blue", 1, 0, 0, 0), ""));
  EXPECT_EQ(s.robots.found, 1U);
  EXPECT_EQ(s.robots.invented, 1U);
  EXPECT_DOUBLE_EQ(s.robot_position_mm.max, 10);
}

TEST(Score, PartlyVisibleThingsMayBeFoundOrNot) {
  const std::string truth = frame("a", robot("blue", 1, 0, 0, 0, false), ball(0, 0, false)) +
                            frame("b", robot("blue", 1, 0, 0, 0, false), "");
  const Score s = scored(frame("a", robot("blue", 1, 30, 0, 0), ball(5, 0)) + frame("b", "", ""), truth);
  EXPECT_EQ(s.robots.expected, 0U);
  EXPECT_EQ(s.robots.found, 0U);
  EXPECT_EQ(s.robots.invented, 0U);
  EXPECT_EQ(s.balls.invented, 0U);
  EXPECT_EQ(s.robot_position_mm.count, 0U);
  // A wrong id still counts.
  EXPECT_EQ(scored(frame("a", robot("blue", 4, 30, 0, 0), "") + frame("b", "", ""), truth).robots.wrong_id,
            1U);
}

TEST(Score, ExpectsWhatShowsEnough) {
  const auto showing = [](double x, bool visible, double share) {
    return Json{{"x", x}, {"y", 0}, {"visible", visible}, {"visible_share", share}}.dump();
  };
  const std::string truth =
      frame("a", "",
            showing(0, true, 1) + "," + showing(1000, false, 0.6) + "," + showing(2000, false, 0.4) + "," +
                ball(3000, 0) + "," + ball(4000, 0, false));  // the last two as from an older simulator
  const std::string detections = frame("a", "", ball(0, 0) + "," + ball(1001, 0) + "," + ball(2002, 0));
  const auto balls_with = [&](double min_visible_share) {
    std::istringstream d(detections), t(truth);
    const Score s = score(d, t, {1, min_visible_share});
    EXPECT_EQ(s.balls.invented, 0U);
    EXPECT_EQ(s.ball_position_mm.count, s.balls.found);
    return std::pair{s.balls.expected, s.balls.found};
  };
  EXPECT_EQ(balls_with(1), (std::pair<std::size_t, std::size_t>{2, 1}));
  EXPECT_EQ(balls_with(0.5), (std::pair<std::size_t, std::size_t>{3, 2}));
  EXPECT_EQ(balls_with(0.4), (std::pair<std::size_t, std::size_t>{4, 3}));
  EXPECT_EQ(scored(detections, truth).balls.expected, 2U);
}

TEST(Score, NamesFramesThatOneSideLacks) {
  const Score s = scored(frame("a", "", "") + frame("x", "", ball(0, 0)),
                         frame("a", "", "") + frame("b", robot("blue", 1, 0, 0, 0), ""));
  EXPECT_EQ(s.frames_compared, 1U);
  EXPECT_THAT(s.frames_without_detections, testing::ElementsAre("b"));
  EXPECT_THAT(s.frames_without_truth, testing::ElementsAre("x"));
  EXPECT_EQ(s.robots.expected, 0U);
  EXPECT_EQ(s.balls.invented, 0U);
  EXPECT_THAT(score_text(s), testing::HasSubstr("1 frames without detections: b\n"));
  EXPECT_EQ(score_json(s)["frames_without_truth"], Json::array({"x"}));
}

TEST(Score, NamesTheLineThatCannotBeRead) {
  const auto error_of = [](const std::string& detections, const std::string& truth) -> std::string {
    try {
      scored(detections, truth);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(error_of(frame("a", "", "") + "nonsense\n", ""), testing::StartsWith("detections, line 2: "));
  EXPECT_THAT(error_of("", R"({"frame":"a","robots":[{}],"balls":[]})"),
              testing::StartsWith("truth, line 1: "));
  EXPECT_EQ(error_of("", frame("a", "", "") + frame("a", "", "")), "truth, line 2: frame \"a\" comes twice");
  EXPECT_THROW(score_files("no/such/file", "nor/this"), std::runtime_error);
}

}  // namespace
}  // namespace sslv::score_test
