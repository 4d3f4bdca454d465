// SPDX-License-Identifier: Apache-2.0
// Robots in drawn images. Each test covers a failure of vision systems in use.
#include "vision/detect_robots.h"

#include "support/allocation_count.h"
#include "support/drawn_scene.h"
#include "vision/segment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace sslv::detect_robots_test {
namespace {

/// The row of item `i`, in rows of this many items.
int row(int i, int in_a_row) {
  return i / in_a_row;
}

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180;
constexpr Rgb kTopColor{24, 24, 27};
constexpr double kHeightMm = 140;
const std::array kColorFormats{PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8};

std::string name_of(const Robot& robot) {
  return std::string(robot.team == Team::kBlue ? "blue " : "yellow ") + std::to_string(robot.id);
}

double turn_between(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, 2 * kPi));
}

const Robot* find(const std::vector<Robot>& robots, Team team, int id) {
  const auto found = std::find_if(robots.begin(), robots.end(),
                                  [&](const Robot& r) { return r.team == team && r.id == id; });
  return found == robots.end() ? nullptr : &*found;
}

/// Whether the scene has this robot, within these tolerances.
bool is_true(const Robot& robot, const DrawnScene& drawn, double within_mm, double within_rad) {
  const auto& all = drawn.things().robots;
  return std::any_of(all.begin(), all.end(), [&](const SimulatedRobot& r) {
    return r.team == robot.team && r.id == robot.id &&
           std::hypot(r.x_mm - robot.x_mm, r.y_mm - robot.y_mm) < within_mm &&
           turn_between(r.orientation_rad, robot.orientation_rad) < within_rad;
  });
}

void expect_nothing_wrong(const std::vector<Robot>& found, const DrawnScene& drawn, double within_mm = 3,
                          double within_deg = 3) {
  for (const Robot& robot : found) {
    EXPECT_TRUE(is_true(robot, drawn, within_mm, within_deg * kDegree))
        << name_of(robot) << " at " << robot.x_mm << ", " << robot.y_mm << " heading "
        << robot.orientation_rad / kDegree << " confidence " << robot.confidence;
  }
}

/// Expects all robots of the scene and nothing else.
void expect_all(const std::vector<Robot>& found, const DrawnScene& drawn, double within_mm,
                double within_deg) {
  EXPECT_EQ(found.size(), drawn.things().robots.size());
  expect_nothing_wrong(found, drawn, within_mm, within_deg);
  for (const SimulatedRobot& r : drawn.things().robots) {
    EXPECT_NE(find(found, r.team, r.id), nullptr)
        << (r.team == Team::kBlue ? "blue " : "yellow ") << r.id << " at " << r.x_mm << ", " << r.y_mm
        << " heading " << r.orientation_rad / kDegree << " is missing";
  }
}

/// Converts a point of a robot's top from the robot's frame to the field's, in mm.
Eigen::Vector2d on_top(const SimulatedRobot& robot, double ahead_mm, double left_mm) {
  const double c = std::cos(robot.orientation_rad), s = std::sin(robot.orientation_rad);
  return {robot.x_mm + c * ahead_mm - s * left_mm, robot.y_mm + s * ahead_mm + c * left_mm};
}

void cover_on_top(DrawnScene& drawn, const SimulatedRobot& robot, double ahead_mm, double left_mm,
                  double radius_mm, Rgb color) {
  const Eigen::Vector2d at = on_top(robot, ahead_mm, left_mm);
  drawn.cover(at.x(), at.y(), robot.height_mm, radius_mm, color);
}

/// Adds every id of both teams at random headings, each near its own point of a grid.
void add_all_robots(DrawnScene& drawn, std::mt19937& random, int covered_dot = -1) {
  std::uniform_real_distribution<double> angle(-kPi, kPi), off(-60, 60);
  for (int i = 0; i < 32; ++i) {
    const double x_mm = -50 + 2600.0 / 3 * row(i, 8), y_mm = -1820 + 520.0 * (i % 8);
    drawn.add_robot(i % 2 == 0 ? Team::kBlue : Team::kYellow, i / 2, x_mm + off(random), y_mm + off(random),
                    angle(random), covered_dot);
  }
}

/// The id whose code differs from this one's only at `dot`; -1 if there is none.
int twin_of(int id, std::size_t dot) {
  const auto& codes = league_patterns().codes;
  for (const auto& code : codes) {
    bool only_there = code.id != id;
    for (std::size_t i = 0; i < 4; ++i) {
      only_there =
          only_there && (code.colors[i] != codes[static_cast<std::size_t>(id)].colors[i]) == (i == dot);
    }
    if (only_there) return code.id;
  }
  return -1;
}

// ---- fully visible robots

class DetectRobotsIn : public ::testing::TestWithParam<PixelFormat> {};

TEST_P(DetectRobotsIn, EveryIdOfBothTeamsAtAnyHeading) {
  std::mt19937 random(1);
  DrawnScene drawn(plain_options(GetParam(), 4));
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    drawn.clear();
    add_all_robots(drawn, random);
    const auto found = drawn.robots().robots;
    expect_all(found, drawn, 0.5, 0.5);
    for (const Robot& robot : found) EXPECT_GT(robot.confidence, 0.95) << name_of(robot);
  }
}

TEST_P(DetectRobotsIn, DotsOfTwoCells) {
  std::mt19937 random(5);
  // 0.08 px/mm; half of that in Bayer quads.
  DrawnScene drawn(plain_options(GetParam(), 4), wide_camera(2.08));
  drawn.use_single_cells();
  for (int round = 0; round < 4; ++round) {
    SCOPED_TRACE(round);
    drawn.clear();
    add_all_robots(drawn, random);
    expect_all(drawn.robots().robots, drawn, is_bayer(GetParam()) ? 1.5 : 1, 1.5);
  }
}

TEST_P(DetectRobotsIn, TeamsOfDifferentHeight) {
  std::mt19937 random(2);
  DrawnScene drawn(plain_options(GetParam(), 4), overhead_camera(), {120, 150});
  add_all_robots(drawn, random);
  const auto found = drawn.robots().robots;
  expect_all(found, drawn, 0.5, 0.5);
  for (const Robot& robot : found) EXPECT_EQ(robot.height_mm, robot.team == Team::kYellow ? 120 : 150);
}

TEST_P(DetectRobotsIn, AnObliqueView) {
  DrawnScene drawn(plain_options(GetParam(), 4), oblique_camera());
  for (int i = 0; i < 16; ++i) {
    drawn.add_robot(i % 2 == 0 ? Team::kBlue : Team::kYellow, i, 300.0 + 450 * row(i, 4),
                    -1300.0 + 820 * (i % 4), 0.7 * i);
  }
  expect_all(drawn.robots().robots, drawn, 0.8, 0.8);
}

TEST_P(DetectRobotsIn, DimLight) {
  std::mt19937 random(3);
  SimulatorOptions options = plain_options(GetParam(), 4);
  options.light = 0.3;
  DrawnScene drawn(options);
  add_all_robots(drawn, random);
  expect_all(drawn.robots().robots, drawn, 1.5, 1.5);
}

TEST_P(DetectRobotsIn, ColouredLight) {
  for (const auto& [red, blue] : {std::pair{1.4, 0.7}, std::pair{0.7, 1.4}}) {
    SCOPED_TRACE(red);
    std::mt19937 random(4);
    SimulatorOptions options = plain_options(GetParam(), 4);
    options.light = 0.7;
    options.red_gain = red, options.blue_gain = blue;
    DrawnScene drawn(options);
    add_all_robots(drawn, random);
    expect_all(drawn.robots().robots, drawn, 0.8, 0.8);
  }
}

TEST_P(DetectRobotsIn, TouchingRobotsKeepTheirDots) {
  // Pairs 1 mm apart, each in all its headings.
  constexpr int kHeadings = 8, kPairs = 8;
  const auto reach_mm = [](int heading) { return heading == 0 ? 55.0 : 90.0; };  // 0: the front touches
  DrawnScene drawn(plain_options(GetParam(), 4));
  int pair = 0;
  for (int a = 0; a < kHeadings; ++a) {
    for (int b = 0; b < kHeadings; ++b, ++pair) {
      const int place = pair % kPairs;
      const double x_mm = 0 + 600.0 * row(place, 2), y_mm = place % 2 == 0 ? -900 : 700;
      const double line = 0.37 * pair, apart_mm = reach_mm(a) + reach_mm(b) + 1;
      // Both of one team, or one of each.
      drawn.add_robot(Team::kBlue, 2 * place, x_mm, y_mm, line - a * kPi / 4);
      drawn.add_robot(pair % 3 == 0 ? Team::kYellow : Team::kBlue, 2 * place + 1,
                      x_mm + apart_mm * std::cos(line), y_mm + apart_mm * std::sin(line),
                      line + kPi - b * kPi / 4);
      if (place + 1 < kPairs) continue;
      SCOPED_TRACE(pair);
      expect_all(drawn.robots().robots, drawn, 1, 1);
      drawn.clear();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, DetectRobotsIn, ::testing::ValuesIn(kColorFormats),
                         [](const auto& param) { return std::string(name_of(param.param)); });

TEST(DetectRobots, ACrowdOfTouchingRobotsSharesNoDots) {
  // The densest packing of discs: dots of two robots are often as close together as dots of one robot.
  DrawnScene drawn;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  for (int i = 0; i < 25; ++i) {
    const int row = i / 5, column = i % 5;
    drawn.add_robot(i % 2 == 0 ? Team::kBlue : Team::kYellow, i / 2, 900 + 157.0 * row,
                    -400 + 181.0 * column + (row % 2 == 0 ? 0 : 90.5), angle(random));
  }
  expect_all(drawn.robots().robots, drawn, 1, 1);
}

TEST(DetectRobots, ACentreDotAwayFromTheCentre) {
  const PatternTable patterns =
      parse_patterns(R"({"name": "lab", "center_diameter_mm": 45, "center": [-25, 15],
      "dot_diameter_mm": 30, "dots": [[45, 20], [10, -50], [-50, -45]],
      "codes": [{"id": 3, "colors": ["pink", "green", "green"]}, {"id": 5, "colors": ["green", "pink", "pink"]}]})",
                     "lab.json");
  DrawnScene drawn;
  drawn.use_patterns(patterns);
  for (int i = 0; i < 16; ++i) {
    drawn.add_robot(i % 2 == 0 ? Team::kBlue : Team::kYellow, i % 4 < 2 ? 3 : 5, 2500 - 600.0 * row(i, 4),
                    -1200.0 + 800 * (i % 4), 0.4 * i);
  }
  DetectRobots::Params params;
  params.duplicates = DetectRobots::Duplicates::kKeep;
  params.min_confidence = 0.1;
  DetectRobots remembers;
  for (const double t_s : {1.0, 1.016}) {
    const RobotList found = drawn.robots_by(remembers, t_s, params);
    EXPECT_EQ(found.robots.size(), 16U);
    expect_nothing_wrong(found.robots, drawn, 2, 2);
    for (const Robot& robot : found.robots) {
      const auto pixel = drawn.scene().camera->project({robot.x_mm, robot.y_mm, robot.height_mm});
      EXPECT_NEAR(robot.pixel_x, pixel->x(), 0.01);
      EXPECT_NEAR(robot.pixel_y, pixel->y(), 0.01);
    }
  }
}

TEST(DetectRobots, DotsThatMergeIntoOneBlob) {
  // Front to front with all dots green: two pairs of dots are only 2 mm apart.
  DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4));
  drawn.add_robot(Team::kBlue, 8, 1000, 0, 0);
  drawn.add_robot(Team::kYellow, 8, 1112, 0, kPi);
  const auto green = drawn.regions().of(label::kGreen);
  const auto large = [](const Region& r) { return r.area_px > 10; };
  ASSERT_LT(std::count_if(green.begin(), green.end(), large), 8) << "the picture is not as the test needs it";
  expect_all(drawn.robots().robots, drawn, 1, 1);
}

TEST(DetectRobots, ADotThatIsSplitInTwoBlobs) {
  for (std::size_t dot = 0; dot < 4; ++dot) {
    SCOPED_TRACE(dot);
    DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4));
    drawn.add_robot(Team::kBlue, 8, 1300, 300, 0.4);
    const SimulatedRobot& robot = drawn.things().robots[0];
    const PatternDot& place = league_patterns().dots[dot];
    const Eigen::Vector2d from = on_top(robot, place.x_mm - 22, place.y_mm),
                          to = on_top(robot, place.x_mm + 22, place.y_mm);
    drawn.cover_bar(from.x(), from.y(), to.x(), to.y(), kHeightMm, 10, kTopColor);
    ASSERT_GT(drawn.regions().of(label::kGreen).size(), 4U) << "the picture is not as the test needs it";
    expect_all(drawn.robots().robots, drawn, 2, 2);
  }
}

TEST(DetectRobots, SpecksOfTheDotsColoursOnTheTopDoNoHarm) {
  for (const double speck_mm : {4.0, 7.0, 10.0}) {
    SCOPED_TRACE(speck_mm);
    DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4));
    for (int id = 0; id < 16; ++id) {
      drawn.add_robot(id % 2 == 0 ? Team::kBlue : Team::kYellow, id, 500.0 * row(id, 4),
                      -1200.0 + 800 * (id % 4), 0.6 * id);
    }
    for (const SimulatedRobot& robot : drawn.things().robots) {
      // Specks in the gaps between the dots: behind, ahead, and at the sides.
      cover_on_top(drawn, robot, -68, 0, speck_mm, paint_color(label::kPink));
      cover_on_top(drawn, robot, 40, 3, speck_mm, paint_color(label::kGreen));
      cover_on_top(drawn, robot, -10, 75, speck_mm, paint_color(label::kGreen));
    }
    expect_all(drawn.robots().robots, drawn, 2, 2);
  }
}

// ---- things that resemble robots

class Missed : public ::testing::Test {
 protected:
  RobotList& process(double t_s, const DetectRobots::Params& params = {},
                     const PatternTable& patterns = league_patterns()) {
    FrameInfo info;
    info.times.t_capture_s = t_s;
    detector_.process(params, drawn_.scene(), patterns, drawn_.lut(), Mask(), info, drawn_.image(),
                      drawn_.regions(), out_, notes_);
    return out_;
  }
  void cover_dot(std::size_t dot, Rgb color) {
    const SimulatedRobot robot = drawn_.things().robots.back();
    const PatternDot& place = league_patterns().dots[dot];
    cover_on_top(drawn_, robot, place.x_mm, place.y_mm, place.diameter_mm / 2 + 1, color);
  }

  DrawnScene drawn_{plain_options(PixelFormat::kUyvy, 2)};
  DetectRobots detector_;
  RobotList out_;
  StageNotes notes_;
};

TEST_F(Missed, ARobotWithoutTwoDotsIsReportedUntilItIsWhole) {
  drawn_.add_robot(Team::kYellow, 2, 1300, 500, 0.4);
  const Robot whole = process(1).robots.at(0);
  EXPECT_THAT(out_.misses, IsEmpty());
  EXPECT_EQ(notes_.read().kind, StageNotes::Kind::kNone);
  cover_dot(0, kTopColor);
  cover_dot(2, kTopColor);
  process(2);
  ASSERT_THAT(out_.misses, SizeIs(1));
  const RobotMiss& miss = out_.misses[0];
  EXPECT_EQ(miss.why, RobotMiss::Why::kDots);
  EXPECT_EQ(miss.dots, 3);
  EXPECT_EQ(miss.of, 5);
  EXPECT_NEAR(miss.pixel_x, whole.pixel_x, 2);
  EXPECT_NEAR(miss.pixel_y, whole.pixel_y, 2);
  EXPECT_GT(miss.radius_px, 5);
  const std::string pixel = fmt::format("at pixel {:.0f}, {:.0f}", miss.pixel_x, miss.pixel_y);
  EXPECT_EQ(notes_.read().text,
            "1 thing resembles a robot, " + pixel +
                ": 3 of 5 dots are at their places; yellow blobs as large as a centre dot: 1");
  drawn_.clear();
  drawn_.add_robot(Team::kYellow, 2, 1300, 500, 0.4);
  process(3);
  EXPECT_THAT(out_.misses, IsEmpty());
  EXPECT_EQ(notes_.read().kind, StageNotes::Kind::kNone);
}

TEST_F(Missed, ColoursThatAreNotCertainAreReported) {
  drawn_.add_robot(Team::kBlue, 2, 1300, 500, 0.4);
  for (const std::size_t dot : {0U, 1U}) cover_dot(dot, paint_color(label::kOrange));
  process(1);
  ASSERT_THAT(out_.misses, SizeIs(1));
  EXPECT_EQ(out_.misses[0].why, RobotMiss::Why::kColors);
  EXPECT_EQ(out_.misses[0].dots, 3);
}

TEST_F(Missed, ARobotWithTwoPossibleIdsIsReported) {
  drawn_.add_robot(Team::kBlue, 2, 1300, 500, 0.4, 1);
  process(1);
  ASSERT_THAT(out_.misses, SizeIs(1));
  EXPECT_EQ(out_.misses[0].why, RobotMiss::Why::kId);
  EXPECT_EQ(out_.misses[0].value, 2);
}

TEST_F(Missed, ARobotBelowTheConfidenceIsReported) {
  drawn_.add_robot(Team::kBlue, 2, 1300, 500, 0.4);
  DetectRobots::Params params;
  params.min_confidence = 1;
  process(1, params);
  ASSERT_THAT(out_.misses, SizeIs(1));
  EXPECT_EQ(out_.misses[0].why, RobotMiss::Why::kConfidence);
  EXPECT_THAT(notes_.read().text, testing::HasSubstr("needed 1.00"));
}

TEST_F(Missed, DotsOfAnotherSizeAreReported) {
  drawn_.add_robot(Team::kBlue, 2, 1300, 500, 0.4);
  PatternTable large = league_patterns();
  large.center_diameter_mm *= 3;
  process(1, {}, large);
  EXPECT_THAT(out_.robots, IsEmpty());
  EXPECT_THAT(notes_.read().text,
              testing::MatchesRegex(
                  "1 thing resembles a robot, .*the centre dot has neither team's colour; of 1 blue "
                  "blobs, the closest in size has 1[0-9] % of a centre dot's area, allowed 20 to 250"));
}

TEST_F(Missed, DotsOffTheirPlacesAreReported) {
  drawn_.add_robot(Team::kBlue, 2, 1300, 500, 0.4);
  PatternTable other = league_patterns();
  other.dots[0].x_mm += 3;
  other.dots[1].y_mm += 3;
  DetectRobots::Params params;
  params.max_rms_mm = 0.5;
  process(1, params, other);
  ASSERT_THAT(out_.misses, SizeIs(1));
  EXPECT_EQ(out_.misses[0].why, RobotMiss::Why::kFit);
  EXPECT_GT(out_.misses[0].value, 0.5);
  EXPECT_EQ(out_.misses[0].limit, 0.5);
}

TEST_F(Missed, RobotsThatTheEdgeOfTheImageCutsAreNotReported) {
  const CameraModel& camera = *drawn_.scene().camera;
  const double width = drawn_.image().view().width, height = drawn_.image().view().height;
  for (const Eigen::Vector2d& pixel :
       {Eigen::Vector2d(2, height / 2), Eigen::Vector2d(width - 2, height / 2), Eigen::Vector2d(width / 2, 2),
        Eigen::Vector2d(width / 2, height - 2)}) {
    const Eigen::Vector2d place = *camera.unproject(pixel, kHeightMm);
    for (int i = 0; i < 8; ++i) {
      drawn_.clear();
      drawn_.add_robot(Team::kBlue, 2, place.x(), place.y(), 0.8 * i);
      EXPECT_THAT(process(1 + i).misses, IsEmpty()) << pixel.transpose() << " " << i;
    }
  }
}

TEST_F(Missed, NotesChangeOnceASecondAndEndWithTheCalibration) {
  drawn_.add_robot(Team::kBlue, 2, 1300, 500, 0.4, 1);
  process(1);
  const std::string text = notes_.read().text;
  EXPECT_THAT(text, testing::HasSubstr("2 ids are possible"));
  drawn_.clear();
  process(1.5);
  EXPECT_EQ(notes_.read().text, text);
  process(2);
  EXPECT_EQ(notes_.read().kind, StageNotes::Kind::kNone);
  drawn_.add_robot(Team::kBlue, 2, 1300, 500, 0.4, 1);
  process(3);
  EXPECT_EQ(notes_.read().text, text);
  drawn_.scene().camera.reset();
  process(3.1);
  EXPECT_EQ(notes_.read().kind, StageNotes::Kind::kNone);
}

// ---- partly hidden robots

/// Expects no robot to be reported with only three visible side dots, which leave two possible ids.
void expect_no_guesses(PixelFormat format, double noise, unsigned seed) {
  std::mt19937 random(seed);
  DrawnScene drawn(plain_options(format, noise));
  for (int dot = 0; dot < 4; ++dot) {
    drawn.clear();
    add_all_robots(drawn, random, dot);
    SCOPED_TRACE(std::string(name_of(format)) + " noise " + std::to_string(noise) + " dot " +
                 std::to_string(dot));
    for (const Robot& robot : drawn.robots().robots) {
      ADD_FAILURE() << "guessed " << name_of(robot) << " at " << robot.x_mm << ", " << robot.y_mm
                    << " confidence " << robot.confidence
                    << (is_true(robot, drawn, 3, 0.05) ? ", rightly" : ", wrongly");
    }
  }
}

TEST(DetectRobots, ACoveredSideDotIsNeverGuessed) {
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kRgb24}) {
    for (unsigned seed = 1; seed <= 4; ++seed) expect_no_guesses(format, 2, seed);
  }
}

TEST(DetectRobots, ACoveredSideDotIsNeverGuessedFromNoise) {
  for (const double noise : {2.0, 4.0, 8.0}) {
    for (unsigned seed = 0; seed < 4; ++seed) expect_no_guesses(PixelFormat::kBayerRg8, noise, seed);
    expect_no_guesses(PixelFormat::kUyvy, noise, 6);
  }
}

/// Covers one dot of each robot. The cover's centre is `out` times as far from the robot's centre as the dot.
void expect_no_wrong_id(double radius_mm, double out, std::span<const Rgb> colors) {
  std::mt19937 random(7);
  DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4));
  for (const Rgb color : colors) {
    for (const PatternDot& dot : league_patterns().dots) {
      drawn.clear();
      add_all_robots(drawn, random);
      const SimulatedScene things = drawn.things();
      for (const SimulatedRobot& robot : things.robots)
        cover_on_top(drawn, robot, out * dot.x_mm, out * dot.y_mm, radius_mm, color);
      SCOPED_TRACE("under " + std::to_string(color.r) + ", " + std::to_string(color.g) + ", " +
                   std::to_string(color.b));
      expect_nothing_wrong(drawn.robots().robots, drawn, 5, 5);
    }
  }
}
constexpr std::array kHands{Rgb{224, 172, 140}, Rgb{120, 80, 60}, Rgb{60, 60, 70}};
constexpr std::array kStickers{Rgb{224, 172, 140}, Rgb{200, 30, 35}, Rgb{205, 205, 200},
                               Rgb{130, 90, 60},   Rgb{30, 92, 62},  Rgb{90, 90, 90}};

TEST(DetectRobots, AHandOverADotNeverGivesAnotherId) {
  expect_no_wrong_id(40, 1.2, kHands);
}

TEST(DetectRobots, AStickerOverADotNeverGivesAnotherId) {
  expect_no_wrong_id(20.5, 1, kStickers);
}

TEST(DetectRobots, TheRosterIdentifiesARobotWithACoveredDot) {
  for (int id = 0; id < 16; ++id) {
    const int dot = id % 4;
    const int twin = twin_of(id, static_cast<std::size_t>(dot));
    DrawnScene drawn;
    drawn.add_robot(Team::kBlue, id, 1300, -500, 0.5 * id, dot);
    auto& roster = drawn.scene().roster[static_cast<std::size_t>(Team::kBlue)];
    roster.set(static_cast<std::size_t>(id));
    expect_all(drawn.robots().robots, drawn, 1, 1);
    if (twin < 0) continue;
    roster.set(static_cast<std::size_t>(twin));
    EXPECT_THAT(drawn.robots().robots, IsEmpty()) << "id " << id << " or " << twin;
  }
}

TEST(DetectRobots, TheOtherRobotsIdentifyARobotWithACoveredDot) {
  // Without one dot, id 8 could be another id, too; but that robot is seen elsewhere.
  for (std::size_t dot = 0; dot < 4; ++dot) {
    const int twin = twin_of(8, dot);
    if (twin < 0) continue;
    DrawnScene drawn;
    drawn.add_robot(Team::kYellow, 8, 1300, -500, 2.1, static_cast<int>(dot));
    drawn.add_robot(Team::kYellow, twin, 1300, 500, -1.1);
    expect_all(drawn.robots().robots, drawn, 1, 1);
  }
}

TEST(DetectRobots, MemoryIdentifiesARobotWithACoveredDot) {
  for (int id = 0; id < 16; ++id) {
    DrawnScene before, after;
    before.add_robot(Team::kYellow, id, 1300, -500, 0.5 * id);
    after.add_robot(Team::kYellow, id, 1320, -490, 0.5 * id + 0.1, id % 4);
    DetectRobots detector;
    expect_all(before.robots_by(detector, 100).robots, before, 0.5, 0.5);
    SCOPED_TRACE(id);
    expect_all(after.robots_by(detector, 100.016).robots, after, 1, 1);
  }
}

TEST(DetectRobots, MemoryFades) {
  DrawnScene before, after;
  before.add_robot(Team::kYellow, 6, 1300, -500, 0.5);
  after.add_robot(Team::kYellow, 6, 1300, -500, 0.5, 1);
  const auto found_after = [&](double pause_s, double memory_ms) {
    DetectRobots detector;
    DetectRobots::Params params;
    params.memory_ms = memory_ms;
    before.robots_by(detector, 100, params);
    return after.robots_by(detector, 100 + pause_s, params).robots;
  };
  EXPECT_THAT(found_after(0.016, 100), SizeIs(1));
  EXPECT_THAT(found_after(0.098, 100), SizeIs(1));
  EXPECT_THAT(found_after(0.102, 100), IsEmpty());
  EXPECT_THAT(found_after(0.016, 0), IsEmpty());
  EXPECT_THAT(found_after(-1, 100), IsEmpty()) << "time went back";
  EXPECT_THAT(found_after(0, 100), IsEmpty()) << "time stood still";
}

TEST(DetectRobots, WithARollingShutterRobotsAreReportedWhereTheyWereAtTheFramesTime) {
  // Two robots drive at 1 m/s, one near the top of the image and one near the bottom.
  DetectRobots detector;
  DetectRobots::Params params;
  params.rolling_shutter_ms = 20;
  const std::array starts{Eigen::Vector2d(600, -900), Eigen::Vector2d(1900, 800)};
  const Eigen::Vector2d speed_mm_s(800, -600);
  for (int frame = 0; frame < 4; ++frame) {
    const double t_s = 0.016 * frame;
    DrawnScene drawn;
    double earliest_s = 0, latest_s = 0;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      Eigen::Vector2d seen = starts[i] + t_s * speed_mm_s;
      for (int round = 0; round < 4; ++round) {
        const double y = drawn.scene().camera->project({seen.x(), seen.y(), 140})->y();
        const double delay_s = (y - 289.5) / 579 * 0.02;
        seen = starts[i] + (t_s + delay_s) * speed_mm_s;
        earliest_s = std::min(earliest_s, delay_s);
        latest_s = std::max(latest_s, delay_s);
      }
      drawn.add_robot(Team::kBlue, static_cast<int>(i), seen.x(), seen.y(), 0.5);
    }
    EXPECT_LT(earliest_s, -0.003);
    EXPECT_GT(latest_s, 0.003);
    const auto robots = drawn.robots_by(detector, 100 + t_s, params).robots;
    ASSERT_THAT(robots, SizeIs(2));
    for (const Robot& robot : robots) {
      const Eigen::Vector2d there = starts[static_cast<std::size_t>(robot.id)] + t_s * speed_mm_s;
      const double off_mm = std::hypot(robot.x_mm - there.x(), robot.y_mm - there.y());
      if (frame == 0) {
        EXPECT_GT(off_mm, 3) << "its speed is not known";
      } else {
        EXPECT_LT(off_mm, 0.5);
      }
    }
  }
}

TEST(DetectRobots, MemoryOfOneRobotIsNotTakenForAnother) {
  // The robot was replaced by another one, whose code differs at two dots; one dot is covered.
  DrawnScene before, after;
  before.add_robot(Team::kYellow, 8, 1300, -500, 0.5);
  after.add_robot(Team::kYellow, 9, 1300, -500, 0.5, 1);
  DetectRobots detector;
  before.robots_by(detector, 100);
  expect_nothing_wrong(after.robots_by(detector, 100.016).robots, after);
}

TEST(DetectRobots, MemoryDoesNotGoWhereTheMaskHides) {
  DrawnScene drawn;
  drawn.add_robot(Team::kYellow, 6, 1300, -500, 0.5);
  const auto found_from_memory = [&](const Mask& mask) {
    DetectRobots detector;
    EXPECT_THAT(drawn.robots_by(detector, 100).robots, SizeIs(1));
    RobotList out;
    FrameInfo info;
    info.times.t_capture_s = 100.016;
    StageNotes notes;
    detector.process({}, drawn.scene(), league_patterns(), drawn.lut(), mask, info, drawn.image(), {}, out,
                     notes);
    return out.robots.size();
  };
  const auto robot = drawn.robots().robots.at(0);
  const auto around = [&](double left, double right) {
    const double x = robot.pixel_x, y = robot.pixel_y;
    return MaskPolygon{{{x - left, y - 9}, {x + right, y - 9}, {x + right, y + 9}, {x - left, y + 9}}};
  };
  EXPECT_EQ(found_from_memory(Mask()), 1U);
  EXPECT_EQ(found_from_memory(Mask({{}, {around(-2, 9)}})), 1U) << "hidden is what lies beside its centre";
  EXPECT_EQ(found_from_memory(Mask({{}, {around(2, 9)}})), 0U);
  EXPECT_EQ(found_from_memory(Mask({{around(2, 9)}, {}})), 1U);
}

TEST(DetectRobots, MemoryNeverMovesARobot) {
  // The same image, with and without an earlier one, gives bit-identical results.
  std::mt19937 random(8);
  DrawnScene before(plain_options(PixelFormat::kUyvy, 4)), now(plain_options(PixelFormat::kUyvy, 4));
  add_all_robots(now, random);
  for (const SimulatedRobot& r : now.things().robots)
    before.add_robot(r.team, r.id, r.x_mm + 15, r.y_mm - 20, r.orientation_rad + 0.15);
  DetectRobots remembers;
  before.robots_by(remembers, 100);
  const auto with = now.robots_by(remembers, 100.016).robots, without = now.robots().robots;
  ASSERT_EQ(with.size(), without.size());
  ASSERT_THAT(with, SizeIs(32));
  for (std::size_t i = 0; i < with.size(); ++i) {
    EXPECT_EQ(with[i].id, without[i].id);
    EXPECT_EQ(with[i].x_mm, without[i].x_mm);
    EXPECT_EQ(with[i].y_mm, without[i].y_mm);
    EXPECT_EQ(with[i].orientation_rad, without[i].orientation_rad);
    EXPECT_EQ(with[i].confidence, without[i].confidence);
  }
}

/// Expects robots with covered centre dots to be found only by a detector with memory.
void expect_memory_without_centre(Rgb color) {
  for (const PixelFormat format : kColorFormats) {
    SCOPED_TRACE(name_of(format));
    DrawnScene before(plain_options(format)), after(plain_options(format));
    for (DrawnScene* drawn : {&before, &after}) {
      drawn->add_robot(Team::kBlue, 3, 700, 800, 0.9);
      drawn->add_robot(Team::kYellow, 12, 1800, -600, -2.3);
    }
    for (const SimulatedRobot& robot : after.things().robots) cover_on_top(after, robot, 0, 0, 26, color);
    DetectRobots detector;
    expect_all(before.robots_by(detector, 5).robots, before, 0.5, 0.5);
    expect_all(after.robots_by(detector, 5.016).robots, after, 1, 1);
    EXPECT_THAT(after.robots().robots, IsEmpty()) << "nothing tells the team";
  }
}

TEST(DetectRobots, ABlackCentreDotNeedsMemory) {
  expect_memory_without_centre(kTopColor);
}

TEST(DetectRobots, AWhiteCentreDotNeedsMemory) {
  expect_memory_without_centre(paint_color(label::kWhite));
}

TEST(DetectRobots, ACentreDotWhoseRegionIsTooLargeIsFoundFromItsSideDots) {
  // A blue object in front of the robot forms one region with its centre dot.
  for (int id = 0; id < 16; ++id) {
    DrawnScene drawn;
    drawn.add_robot(Team::kBlue, id, 1300, 400, 0.8 * id);
    cover_on_top(drawn, drawn.things().robots[0], 57, 0, 33, paint_color(label::kBlue));
    ASSERT_THAT(drawn.regions().of(label::kBlue), SizeIs(1));
    ASSERT_GT(drawn.regions().of(label::kBlue)[0].area_px, 2.5 * 62)
        << "the picture is not as the test needs it";
    SCOPED_TRACE(id);
    expect_all(drawn.robots().robots, drawn, 3, 3);
  }
}

TEST(DetectRobots, HalfOutOfThePictureIsRightOrNotReported) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  for (const PixelFormat format : kColorFormats) {
    DrawnScene drawn(plain_options(format, 4));
    const auto at = [&](double u, double v) { return *drawn.scene().camera->unproject({u, v}, kHeightMm); };
    for (int step = 0; step < 4; ++step) {
      // On all sides, farther out in each step; the corners too.
      drawn.clear();
      const double in_px = 14 - 5.0 * step;
      std::vector<Eigen::Vector2d> places;
      for (int i = 0; i < 8; ++i) {
        const double u = 60 + 92.0 * i, v = 60 + 70.0 * i;
        places.push_back(at(u, in_px));
        places.push_back(at(u, 579 - in_px));
        if (i == 7) continue;
        places.push_back(at(in_px, v));
        places.push_back(at(779 - in_px, v));
      }
      int number = 0;
      for (const Eigen::Vector2d& p : places) {
        drawn.add_robot(number % 2 == 0 ? Team::kBlue : Team::kYellow, number / 2, p.x(), p.y(),
                        angle(random));
        ++number;
      }
      SCOPED_TRACE(std::string(name_of(format)) + " step " + std::to_string(step));
      expect_nothing_wrong(drawn.robots().robots, drawn);
    }
    // Side dots and centres exactly in the corners: nothing may be read outside the image.
    for (const double in_px : {0.0, 5.0, 11.0, 14.0}) {
      drawn.clear();
      int id = 0;
      for (const double u : {in_px, 779 - in_px}) {
        for (const double v : {in_px, 579 - in_px}) {
          const Eigen::Vector2d p = at(u, v);
          drawn.add_robot(Team::kBlue, id++, p.x(), p.y(), angle(random));
        }
      }
      SCOPED_TRACE(std::string(name_of(format)) + " corners " + std::to_string(in_px));
      expect_nothing_wrong(drawn.robots().robots, drawn);
    }
  }
}

// ---- duplicates

TEST(DetectRobots, TwoRobotsNeverShareADot) {
  // A centre dot and three side dots lie beside a robot so that one of its own dots completes them.
  for (std::size_t own = 0; own < 4; ++own) {
    for (std::size_t other = 0; other < 4; ++other) {
      DrawnScene drawn;
      drawn.add_robot(Team::kBlue, 8, 1300, 0, 0.3);
      const SimulatedRobot robot = drawn.things().robots[0];
      const auto& dots = league_patterns().dots;
      const Eigen::Vector2d shared = on_top(robot, dots[own].x_mm, dots[own].y_mm);
      // This heading turns the phantom's dot `other` towards the robot.
      const double towards = std::atan2(robot.y_mm - shared.y(), robot.x_mm - shared.x());
      const double heading = towards + kPi - std::atan2(dots[other].y_mm, dots[other].x_mm) + kPi;
      const double c = std::cos(heading), s = std::sin(heading);
      const Eigen::Vector2d center = shared - Eigen::Vector2d(c * dots[other].x_mm - s * dots[other].y_mm,
                                                              s * dots[other].x_mm + c * dots[other].y_mm);
      const SimulatedRobot phantom{Team::kBlue, 8, center.x(), center.y(), heading, kHeightMm};
      // The phantom's black top, beside the robot's.
      cover_on_top(drawn, phantom, 0, 0, 44, kTopColor);
      for (std::size_t i = 0; i < 4; ++i) {
        if (i == other) continue;
        cover_on_top(drawn, phantom, dots[i].x_mm, dots[i].y_mm, 29, kTopColor);
      }
      cover_on_top(drawn, phantom, 0, 0, 25, paint_color(label::kYellow));
      for (std::size_t i = 0; i < 4; ++i) {
        if (i != other)
          cover_on_top(drawn, phantom, dots[i].x_mm, dots[i].y_mm, 20, paint_color(label::kGreen));
      }
      EXPECT_LE(drawn.robots().robots.size(), 1U) << own << " is " << other;
    }
  }
}

TEST(DetectRobots, AnIdIsReportedOncePerTeam) {
  DrawnScene drawn;
  drawn.add_robot(Team::kBlue, 5, 500, 500, 1.0);
  drawn.add_robot(Team::kBlue, 5, 1500, 500, 1.0);
  drawn.add_robot(Team::kYellow, 5, 1500, -500, 1.0);
  const RobotList found = drawn.robots();
  EXPECT_THAT(found.robots, SizeIs(2));
  // The other one is returned as well, so that it can be reported.
  ASSERT_THAT(found.second_robots, SizeIs(1));
  EXPECT_EQ(found.second_robots[0].team, Team::kBlue);
  EXPECT_EQ(found.second_robots[0].id, 5);
  EXPECT_GT(found.second_robots[0].confidence, 0.9);

  DetectRobots::Params params;
  params.duplicates = DetectRobots::Duplicates::kKeep;
  const auto all = drawn.robots(params).robots;
  ASSERT_THAT(all, SizeIs(3));
  expect_nothing_wrong(all, drawn, 0.5, 0.5);
  EXPECT_EQ(all[2].team, Team::kBlue);
  EXPECT_LE(all[2].confidence, 0.25);
  EXPECT_GT(all[1].confidence, 0.95);
}

// ---- no robot, no colour, no calibration

TEST(DetectRobots, ConfidenceIsANumberFromZeroToOneAndFallsInTheList) {
  std::mt19937 random(10);
  DetectRobots::Params params;
  params.min_confidence = 0;
  params.max_rms_mm = 30;
  params.min_area_ratio = 0;
  for (const double noise : {0.0, 4.0, 25.0}) {
    DrawnScene drawn(plain_options(PixelFormat::kUyvy, noise));
    add_all_robots(drawn, random);
    const auto found = drawn.robots(params).robots;
    EXPECT_THAT(found, Not(IsEmpty()));
    double last = 1;
    for (const Robot& robot : found) {
      EXPECT_GE(robot.confidence, 0);
      EXPECT_LE(robot.confidence, last);
      last = robot.confidence;
    }
  }
}

TEST(DetectRobots, NothingWithoutACalibration) {
  DrawnScene drawn;
  drawn.add_robot(Team::kBlue, 9, 1500, 500, 1.0);
  EXPECT_THAT(drawn.robots().robots, SizeIs(1));
  drawn.scene().camera.reset();
  EXPECT_THAT(drawn.robots().robots, IsEmpty());
}

TEST(DetectRobots, NothingInAPictureWithoutColours) {
  DrawnScene drawn(plain_options(PixelFormat::kMono8));
  drawn.add_robot(Team::kBlue, 9, 1500, 500, 1.0);
  EXPECT_THAT(drawn.robots().robots, IsEmpty());
  // Nothing is read either with another image's regions or a remembered robot.
  DrawnScene colored;
  colored.add_robot(Team::kBlue, 9, 1500, 500, 1.0);
  DetectRobots detector;
  ASSERT_THAT(colored.robots_by(detector, 1).robots, SizeIs(1));
  RobotList out;
  FrameInfo info;
  info.times.t_capture_s = 1.016;
  StageNotes notes;
  detector.process({}, drawn.scene(), league_patterns(), drawn.lut(), Mask(), info, drawn.image(),
                   colored.regions(), out, notes);
  EXPECT_THAT(out.robots, IsEmpty());
}

TEST(DetectRobots, APictureOfAnotherSizeThanTheCalibrationsIsSurvived) {
  for (const PixelFormat format : kColorFormats) {
    SimulatorOptions options = plain_options(format);
    options.width = 390, options.height = 290;
    DrawnScene small(options);
    small.add_robot(Team::kBlue, 9, 1300, 1000, 1.0);
    small.add_robot(Team::kYellow, 2, 2000, 30, 1.0);
    EXPECT_LE(small.robots().robots.size(), 2U);
    // Regions and memory left by a larger image.
    DrawnScene large(plain_options(format));
    std::mt19937 random(11);
    add_all_robots(large, random);
    DetectRobots detector;
    large.robots_by(detector, 1);
    RobotList out;
    FrameInfo info;
    info.times.t_capture_s = 1.016;
    StageNotes notes;
    detector.process({}, small.scene(), league_patterns(), small.lut(), Mask(), info, small.image(),
                     large.regions(), out, notes);
    EXPECT_LE(out.robots.size(), 2U);
  }
}

/// An image of thousands of 4 px squares in the prints' colours.
class Confetti {
 public:
  explicit Confetti(unsigned seed) : bytes_(780 * 580 * 3) {
    std::mt19937 random(seed);
    constexpr std::array kLabels{label::kOrange, label::kYellow, label::kBlue,  label::kPink,
                                 label::kGreen,  label::kWhite,  label::kBlack, label::kField};
    for (std::size_t y = 0; y < 580; y += 8) {
      for (std::size_t x = 0; x < 780; x += 8) {
        const Rgb c = paint_color(kLabels[random() % kLabels.size()]);
        for (std::size_t i = 0; i < 16; ++i) {
          std::uint8_t* out = bytes_.data() + ((y + i / 4) * 780 + x + i % 4) * 3;
          out[0] = c.r, out[1] = c.g, out[2] = c.b;
        }
      }
    }
  }
  Image image() const {
    return {{bytes_.data(), 780, 580, 780 * 3, PixelFormat::kRgb24}, nullptr, nullptr, nullptr};
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

TEST(DetectRobots, ThousandsOfBlobsEndAndAllocateNothingTheSecondTime) {
  DrawnScene drawn;  // only for its camera and colours
  Segment segment;
  DetectRobots detector;
  RunList runs;
  RegionList regions;
  RobotList out;
  StageNotes notes;
  const Mask mask;
  for (unsigned seed = 1; seed <= 2; ++seed) {
    const Confetti confetti(seed);
    const Image image = confetti.image();
    segment.process({}, drawn.lut(), mask, image, runs, regions);
    ASSERT_GT(regions.regions.size(), 3000U);
    for (const int most : {100, 3000}) {
      DetectRobots::Params params;
      params.max_work = most;
      const auto process = [&](double t_s) {
        FrameInfo info;
        info.times.t_capture_s = t_s;
        detector.process(params, drawn.scene(), league_patterns(), drawn.lut(), mask, info, image, regions,
                         out, notes);
      };
      process(1);
      EXPECT_TRUE(out.capped) << most;
      const std::uint64_t before = allocation_count();
      process(1.016);
      if (counts_allocations()) {
        EXPECT_EQ(allocation_count() - before, 0U) << most;
      }
      for (const Robot& robot : out.robots) ADD_FAILURE() << "there is no " << name_of(robot);
    }
  }
}

/// A grid of discs at robot height, with alternating colours.
void cover_with_discs(DrawnScene& drawn, double from_x_mm, double to_x_mm, double apart_mm,
                      double diameter_mm, std::span<const Label> colors) {
  std::size_t count = 0;
  for (double x_mm = from_x_mm; x_mm < to_x_mm; x_mm += apart_mm) {
    for (double y_mm = -1600; y_mm < 1600; y_mm += apart_mm)
      drawn.cover(x_mm, y_mm, kHeightMm, diameter_mm / 2, paint_color(colors[count++ % colors.size()]));
  }
}

TEST(DetectRobots, ABoardOfSideDotColoursDoesNotStarveARememberedRobot) {
  DrawnScene before, after;
  for (DrawnScene* drawn : {&before, &after}) drawn->add_robot(Team::kBlue, 5, 2600, 300, 0.7);
  cover_on_top(after, after.things().robots[0], 0, 0, 26, kTopColor);
  constexpr std::array kSideColors{label::kPink, label::kGreen, label::kGreen};
  cover_with_discs(after, -700, 1700, 75, 40, kSideColors);
  DetectRobots detector;
  expect_all(before.robots_by(detector, 5).robots, before, 0.5, 0.5);
  const RobotList found = after.robots_by(detector, 5.016);
  EXPECT_TRUE(found.capped) << "the picture is not as the test needs it";
  EXPECT_NE(find(found.robots, Team::kBlue, 5), nullptr);
  expect_nothing_wrong(found.robots, after, 1, 1);
}

TEST(DetectRobots, BlobsWithoutSideDotsDoNotStarveRobots) {
  constexpr std::array kYellow{label::kYellow};
  DrawnScene drawn;
  cover_with_discs(drawn, -700, 2000, 95, 50, kYellow);
  for (int i = 0; i < 6; ++i) {
    drawn.add_robot(i % 2 == 0 ? Team::kYellow : Team::kBlue, i, 2400 + 300 * row(i, 4),
                    -1200 + 600 * (i % 4), 0.9 * i);
  }
  ASSERT_GT(drawn.regions().of(label::kYellow).size(), 800U) << "the picture is not as the test needs it";
  expect_all(drawn.robots().robots, drawn, 0.5, 0.5);
}

TEST(DetectRobots, AnOrdinaryPictureIsNotCapped) {
  std::mt19937 random(12);
  DrawnScene drawn;
  add_all_robots(drawn, random);
  EXPECT_FALSE(drawn.robots().capped);
}

}  // namespace
}  // namespace sslv::detect_robots_test
