// SPDX-License-Identifier: Apache-2.0
// Balls in drawn images. Each test covers a failure of vision systems in use.
#include "vision/detect_balls.h"

#include "support/allocation_count.h"
#include "support/drawn_scene.h"
#include "vision/segment.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::detect_balls_test {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kPi = std::numbers::pi;
constexpr double kBallMm = 21.5;
const std::array kColorFormats{PixelFormat::kUyvy, PixelFormat::kRgb24, PixelFormat::kBayerRg8};
using Shape = SimulatedDistractor::Shape;

/// Expects each reported ball to be near one of the scene's.
void expect_true(const std::vector<Ball>& found, const DrawnScene& drawn, double within_mm) {
  const auto& balls = drawn.things().balls;
  for (const Ball& ball : found) {
    double nearest_mm = 1e9;
    for (const SimulatedBall& other : balls)
      nearest_mm = std::min(nearest_mm, std::hypot(other.x_mm - ball.x_mm, other.y_mm - ball.y_mm));
    EXPECT_LT(nearest_mm, within_mm) << "at " << ball.x_mm << ", " << ball.y_mm << " confidence "
                                     << ball.confidence;
  }
}

/// Expects each ball of the scene once, within this distance, and nothing else.
void expect_all(const std::vector<Ball>& found, const DrawnScene& drawn, double within_mm) {
  EXPECT_EQ(found.size(), drawn.things().balls.size());
  expect_true(found, drawn, within_mm);
  for (const SimulatedBall& ball : drawn.things().balls) {
    const bool is_found = std::any_of(found.begin(), found.end(), [&](const Ball& other) {
      return std::hypot(other.x_mm - ball.x_mm, other.y_mm - ball.y_mm) < within_mm;
    });
    EXPECT_TRUE(is_found) << "ball at " << ball.x_mm << ", " << ball.y_mm;
  }
}

/// Expects no ball, although the image has an orange region.
void expect_no_ball(DrawnScene& drawn, const std::string& what) {
  EXPECT_FALSE(drawn.regions().of(label::kOrange).empty())
      << what << ": the picture is not as the test needs it";
  for (const Ball& ball : drawn.balls().balls)
    ADD_FAILURE() << what << ": no ball at " << ball.x_mm << ", " << ball.y_mm << " confidence "
                  << ball.confidence;
}

// ---- positions of balls

class DetectBallsIn : public ::testing::TestWithParam<PixelFormat> {};

/// Ten balls between the lines, in each round at other places.
void scatter_balls(DrawnScene& drawn, std::mt19937& random, int round) {
  std::uniform_real_distribution<double> off(-40, 40);
  drawn.clear();
  for (int i = 0; i < 10; ++i) {
    const double y_mm = 200.0 + 300 * (round % 6) + off(random);
    drawn.add_ball(750 + 430.0 * (i / 2) + off(random), i % 2 == 0 ? -y_mm : y_mm);
  }
}

TEST_P(DetectBallsIn, OnFreeCarpet) {
  std::mt19937 random(1);
  DrawnScene drawn(plain_options(GetParam()));
  for (int round = 0; round < 6; ++round) {
    scatter_balls(drawn, random, round);
    SCOPED_TRACE(round);
    // Red and blue samples of Bayer images are two pixels apart: seven each on a ball.
    expect_all(drawn.balls().balls, drawn, is_bayer(GetParam()) ? 0.8 : 0.4);
  }
}

TEST_P(DetectBallsIn, OnFreeCarpetOnAverage) {
  std::mt19937 random(2);
  DrawnScene drawn(plain_options(GetParam()));
  double squares = 0;
  int balls = 0;
  for (int round = 0; round < 6; ++round) {
    scatter_balls(drawn, random, round);
    for (const Ball& ball : drawn.balls().balls) {
      double nearest_mm = 1e9;
      for (const SimulatedBall& other : drawn.things().balls)
        nearest_mm = std::min(nearest_mm, std::hypot(other.x_mm - ball.x_mm, other.y_mm - ball.y_mm));
      squares += nearest_mm * nearest_mm;
      ++balls;
    }
  }
  EXPECT_EQ(balls, 60);
  EXPECT_LT(std::sqrt(squares / balls), 0.4);
}

TEST_P(DetectBallsIn, OfLessThanTwoCells) {
  std::mt19937 random(3);
  // 0.08 px/mm; half of that in Bayer quads.
  DrawnScene drawn(plain_options(GetParam(), 4), wide_camera(2.08));
  drawn.use_single_cells();
  for (int round = 0; round < 6; ++round) {
    scatter_balls(drawn, random, round);
    SCOPED_TRACE(round);
    expect_all(drawn.balls().balls, drawn, is_bayer(GetParam()) ? 8 : 3);
  }
}

TEST(DetectBalls, TwoCellDotsOfAnUndetectedRobotAreNoBalls) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> off(-30, 30), angle(-kPi, kPi);
  DrawnScene drawn(plain_options(PixelFormat::kBayerRg8, 4), wide_camera(2.08));
  drawn.use_single_cells();
  for (int i = 0; i < 32; ++i) {
    drawn.add_robot(i % 2 == 0 ? Team::kBlue : Team::kYellow, i / 2, 100 + 300.0 * (i % 8) + off(random),
                    -700 + 400.0 * (i / 8) + off(random), angle(random));
  }
  BallList found;
  DetectBalls().process({}, drawn.scene(), drawn.lut(), Mask(), {}, drawn.image(), drawn.regions(), {},
                        found);
  for (const Ball& ball : found.balls)
    ADD_FAILURE() << "no ball at " << ball.x_mm << ", " << ball.y_mm << " confidence " << ball.confidence;
}

TEST_P(DetectBallsIn, ABallCutByTheMaskIsNotReported) {
  DrawnScene drawn(plain_options(GetParam()));
  drawn.add_ball(1000, 300);
  drawn.add_ball(1500, -600);
  const auto cut_px = drawn.scene().camera->project({1000, 300, kBallMm});
  ASSERT_TRUE(cut_px);
  // Hides the right half of the first ball.
  const double x = cut_px->x(), y = cut_px->y();
  MaskSettings settings;
  settings.exclude = {{{{x, y - 40}, {x + 40, y - 40}, {x + 40, y + 40}, {x, y + 40}}}};
  const Mask mask(settings);
  RunList runs;
  RegionList regions;
  Segment().process({}, drawn.lut(), mask, drawn.image(), runs, regions);
  const auto found = [&](const Mask& looked_at) {
    BallList out;
    DetectBalls().process({}, drawn.scene(), drawn.lut(), looked_at, {}, drawn.image(), regions, {}, out);
    return out.balls;
  };
  EXPECT_THAT(found(Mask()), SizeIs(2)) << "the piece does not look like a ball: the test shows nothing";
  ASSERT_THAT(found(mask), SizeIs(1));
  EXPECT_NEAR(found(mask).front().x_mm, 1500, 1);
}

TEST_P(DetectBallsIn, TapeFitsARectangleBetter) {
  DrawnScene drawn(plain_options(GetParam(), 4));
  drawn.add_thing({Shape::kRectangle, label::kOrange, 1200, 300, 0.4, 38, 38});
  drawn.add_ball(1500, -600);
  const BallFitter::Frame frame{drawn.image().view(), *drawn.scene().camera, kBallMm, {}, 90, 55, 0.5};
  BallFitter fitter;
  const BallFit tape = fitter.fit(frame, 1200, 300), ball = fitter.fit(frame, 1500, -600);
  ASSERT_TRUE(tape.ok && ball.ok);
  EXPECT_GT(fitter.rectangle_gain(frame, tape), 0.1);
  EXPECT_LT(fitter.rectangle_gain(frame, ball), -0.1);
  const std::uint64_t before = allocation_count();
  fitter.rectangle_gain(frame, tape);
  EXPECT_EQ(allocation_count(), before);
}

TEST_P(DetectBallsIn, AnObliqueView) {
  DrawnScene drawn(plain_options(GetParam(), 4), oblique_camera());
  for (int i = 0; i < 10; ++i) drawn.add_ball(750 + 230.0 * i, -1000 + 300.0 * (i % 7));
  expect_all(drawn.balls().balls, drawn, is_bayer(GetParam()) ? 1.2 : 0.6);
}

TEST_P(DetectBallsIn, BesideAndOverALine) {
  DrawnScene drawn(plain_options(GetParam(), 4));
  std::size_t lost = 0;
  for (int round = 0; round < 4; ++round) {
    drawn.clear();
    for (int i = 0; i < 5; ++i) {
      const double off_mm = -36 + 8.5 * i + 3.0 * round;
      drawn.add_ball(off_mm, 800 + 150.0 * i);  // halfway line
      drawn.add_ball((500 + off_mm) * std::cos(0.25 * i),
                     (500 + off_mm) * std::sin(0.25 * i));  // centre circle
    }
    SCOPED_TRACE(round);
    const auto& found = drawn.balls().balls;
    expect_true(found, drawn, is_bayer(GetParam()) ? 2 : 1.5);
    lost += drawn.things().balls.size() - found.size();
  }
  // On a line, a Bayer image may have too few samples of ball or carpet.
  EXPECT_LE(lost, is_bayer(GetParam()) ? 1U : 0U) << "of 40";
}

TEST_P(DetectBallsIn, WhereLinesCross) {
  DrawnScene drawn(plain_options(GetParam(), 4));
  for (int i = 0; i < 5; ++i) drawn.add_ball(-20 + 10.0 * i, (i % 2 == 0 ? 500 : -500) + (-50 + 25.0 * i));
  const auto balls = drawn.things().balls;
  for (const SimulatedBall& ball : balls) {
    drawn.clear();
    drawn.add_ball(ball.x_mm, ball.y_mm);
    expect_all(drawn.balls().balls, drawn, 2);
  }
}

TEST_P(DetectBallsIn, AtARobotsFront) {
  // Robots farther from the point below the camera face inwards: otherwise they would hide the ball.
  DrawnScene drawn(plain_options(GetParam(), 4));
  const auto add = [&](int id, const Eigen::Vector2d& robot, double heading) {
    drawn.add_robot(id % 2 == 0 ? Team::kBlue : Team::kYellow, id, robot.x(), robot.y(), heading);
    drawn.add_ball(robot.x() + (55 + kBallMm) * std::cos(heading),
                   robot.y() + (55 + kBallMm) * std::sin(heading));
  };
  const Eigen::Vector2d foot(1250, 0);
  for (int i = 0; i < 4; ++i) {
    const double direction = 0.4 + i * kPi / 2;
    const Eigen::Vector2d out(std::cos(direction), std::sin(direction));
    add(i, foot + 250 * out, 1.9 * i);
    add(4 + i, foot + 1200 * out, direction + kPi + 0.6 * (i - 1.5));
  }
  expect_all(drawn.balls().balls, drawn, 4);
}

TEST_P(DetectBallsIn, HalfHiddenBehindARobot) {
  // The ball's centre lies behind the edge of the robot's top.
  DrawnScene drawn(plain_options(GetParam(), 4));
  const Eigen::Vector3d eye = drawn.scene().camera->position_mm();
  for (int i = 0; i < 8; ++i) {
    const double direction = 0.3 + i * kPi / 4, far_mm = 900 + 50.0 * (i % 3);
    const Eigen::Vector2d out(std::cos(direction), std::sin(direction));
    const Eigen::Vector2d robot = eye.head<2>() + far_mm * out;
    drawn.add_robot(i % 2 == 0 ? Team::kBlue : Team::kYellow, i, robot.x(), robot.y(),
                    direction + kPi + 0.3 * i - 1);
    const Eigen::Vector2d ball = eye.head<2>() + (far_mm + 90) * (eye.z() - kBallMm) / (eye.z() - 140) * out;
    drawn.add_ball(ball.x(), ball.y());
  }
  expect_all(drawn.balls().balls, drawn, 4);
}

TEST_P(DetectBallsIn, HalfHiddenNearlyAlways) {
  DrawnScene drawn(plain_options(GetParam(), 4));
  const Eigen::Vector3d eye = drawn.scene().camera->position_mm();
  std::size_t lost = 0;
  for (int round = 0; round < 12; ++round) {
    drawn.clear();
    for (int i = 0; i < 8; ++i) {
      const double direction = 0.1 + 0.07 * round + i * kPi / 4, far_mm = 700 + 45.0 * ((i + round) % 9);
      const Eigen::Vector2d out(std::cos(direction), std::sin(direction));
      const Eigen::Vector2d robot = eye.head<2>() + far_mm * out;
      drawn.add_robot(i % 2 == 0 ? Team::kBlue : Team::kYellow, i, robot.x(), robot.y(), direction + kPi);
      const Eigen::Vector2d ball =
          eye.head<2>() + (far_mm + 88 + i % 4) * (eye.z() - kBallMm) / (eye.z() - 140) * out;
      drawn.add_ball(ball.x(), ball.y());
    }
    const auto& found = drawn.balls().balls;
    expect_true(found, drawn, 8);
    lost += drawn.things().balls.size() - found.size();
  }
  EXPECT_LE(lost, 0U) << "of 96";
}

TEST_P(DetectBallsIn, TwoBallsAlmostTouching) {
  DrawnScene drawn(plain_options(GetParam(), 4));
  for (int i = 0; i < 5; ++i) {
    const double x_mm = 750 + 400.0 * i, y_mm = 300, angle = 0.6 * i;
    drawn.add_ball(x_mm, y_mm);
    drawn.add_ball(x_mm + 48 * std::cos(angle), y_mm + 48 * std::sin(angle));
  }
  expect_all(drawn.balls().balls, drawn, 2);
}

TEST_P(DetectBallsIn, DimLight) {
  SimulatorOptions options = plain_options(GetParam(), 4);
  options.light = 0.3;
  DrawnScene drawn(options);
  for (int i = 0; i < 10; ++i) drawn.add_ball(750 + 430.0 * (i / 2), i % 2 == 0 ? -700 : 800);
  expect_all(drawn.balls().balls, drawn, 2);
}

TEST_P(DetectBallsIn, AnotherRadius) {
  FieldSize field;
  field.ball_radius = 38.5;
  DrawnScene drawn(plain_options(GetParam(), 4), overhead_camera(), {140, 140}, field);
  for (int i = 0; i < 10; ++i) drawn.add_ball(750 + 430.0 * (i / 2), i % 2 == 0 ? -700 : 800);
  expect_all(drawn.balls().balls, drawn, 0.4);
}

INSTANTIATE_TEST_SUITE_P(Formats, DetectBallsIn, ::testing::ValuesIn(kColorFormats),
                         [](const auto& param) { return std::string(name_of(param.param)); });

// ---- things that are not balls

TEST(DetectBalls, APinkDotIsNoBall) {
  DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4));
  drawn.add_thing({Shape::kEllipse, label::kPink, 1300, 400, 0, 43, 43});
  for (int id = 0; id < 16; ++id)
    drawn.add_robot(Team::kBlue, id, 500.0 * (id / 4), -1300.0 + 800 * (id % 4), id);
  EXPECT_THAT(drawn.balls().balls, IsEmpty());
}

TEST(DetectBalls, ALineCrossingIsNoBall) {
  for (const double red : {1.0, 1.4}) {
    SimulatorOptions options = plain_options(PixelFormat::kUyvy, 8);
    options.red_gain = red;
    DrawnScene drawn(options);
    EXPECT_THAT(drawn.balls().balls, IsEmpty());
  }
}

TEST(DetectBalls, ARobotsOrangeCentreDotIsNoBall) {
  DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4));
  for (int i = 0; i < 6; ++i) {
    drawn.add_robot(Team::kYellow, i, 900 + 500.0 * (i / 2), i % 2 == 0 ? -700 : 700, i);
    const SimulatedRobot robot = drawn.things().robots[static_cast<std::size_t>(i)];
    drawn.cover(robot.x_mm, robot.y_mm, 140, 25, {235, 130, 34});
  }
  ASSERT_EQ(drawn.regions().of(label::kOrange).size(), 6U) << "the picture is not as the test needs it";
  expect_no_ball(drawn, "yellow that reads as orange");
  EXPECT_THAT(drawn.robots().robots, SizeIs(6));
}

TEST(DetectBalls, AnOrangeDiscOfAnotherSizeIsNoBall) {
  for (const PixelFormat format : kColorFormats) {
    for (const double factor : {0.5, 1.5, 2.0, 3.0}) {
      DrawnScene drawn(plain_options(format, 4));
      for (int i = 0; i < 4; ++i)
        drawn.add_thing({Shape::kEllipse, label::kOrange, 800 + 400.3 * i, 300, 0, 43 * factor, 43 * factor});
      expect_no_ball(drawn, std::string(name_of(format)) + " factor " + std::to_string(factor));
    }
  }
}

TEST(DetectBalls, AnOrangeSquareOrStripeIsNoBall) {
  struct Form {
    double length_mm, width_mm;
  };
  for (const PixelFormat format : kColorFormats) {
    for (const Form& form :
         {Form{60, 60}, Form{75, 75}, Form{150, 12}, Form{300, 30}, Form{90, 20}, Form{25, 25}}) {
      DrawnScene drawn(plain_options(format, 4));
      for (int i = 0; i < 4; ++i)
        drawn.add_thing({Shape::kRectangle, label::kOrange, 800 + 400.3 * i, 300, 0.4 * i, form.length_mm,
                         form.width_mm});
      expect_no_ball(drawn, std::string(name_of(format)) + " " + std::to_string(form.length_mm) + " x " +
                                std::to_string(form.width_mm));
    }
  }
}

TEST(DetectBalls, RestingTapeOfABallsSizeIsNoBall) {
  for (const PixelFormat format : kColorFormats) {
    DrawnScene drawn(plain_options(format, 4));
    const std::array<std::array<double, 2>, 3> sizes_mm{{{38, 38}, {42, 36}, {45, 30}}};
    for (int i = 0; i < 6; ++i) {
      const auto& [length_mm, width_mm] = sizes_mm[static_cast<std::size_t>(i % 3)];
      drawn.add_thing(
          {Shape::kRectangle, label::kOrange, 800 + 300.3 * i, 300, 0.4 * i, length_mm, width_mm});
    }
    drawn.add_ball(1500, -600);
    DetectBalls detector;
    for (int i = 0; i < 8; ++i) {
      drawn.expose_again();
      FrameInfo info;
      info.times.t_capture_s = 100 + i / 60.0;
      const RegionList& regions = drawn.regions();
      BallList out;
      detector.process({}, drawn.scene(), drawn.lut(), Mask(), info, drawn.image(), regions, {}, out);
      EXPECT_THAT(out.balls, SizeIs(testing::Ge(1U)));
      if (i > 0) expect_true(out.balls, drawn, 1);
    }
  }
}

TEST(DetectBalls, AnOrangeBagIsNoBall) {
  for (const double size_mm : {100.0, 300.0}) {
    DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4));
    drawn.cover(1300, 300, 200, size_mm / 2, paint_color(label::kOrange));
    drawn.cover_bar(1700, -300, 1700 + size_mm, -300, 50, size_mm, paint_color(label::kOrange));
    drawn.cover_bar(1700, -1000, 1700 + size_mm, -1100, 300, size_mm / 2, {230, 90, 25});
    expect_no_ball(drawn, "bag");
  }
}

TEST(DetectBalls, NoneFarOutsideTheField) {
  FieldSize field;
  field.field_width = 2000;
  field.field_length = 4000;
  DrawnScene drawn(plain_options(), overhead_camera(), {140, 140}, field);
  drawn.add_ball(1400, 1250);
  const std::size_t inside = drawn.things().balls.size();
  drawn.add_ball(1400, 1350);
  drawn.add_ball(2350, 100);
  EXPECT_THAT(drawn.balls().balls, SizeIs(inside));
  DetectBalls::Params params;
  params.max_outside_mm = 0;
  EXPECT_THAT(drawn.balls(params).balls, IsEmpty());
  params.max_outside_mm = 400;
  EXPECT_THAT(drawn.balls(params).balls, SizeIs(3));
}

TEST(DetectBalls, AStandingThingOffTheFieldIsNoBall) {
  FieldSize field;
  field.field_width = 2000;
  field.field_length = 4000;
  DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4), overhead_camera(), {140, 140}, field);
  drawn.add_ball(1400, 1200);                          // off the field
  drawn.add_ball(1400, 300);                           // on it
  drawn.add_ball(2000 + field.goal_depth / 2.0, -20);  // in the goal
  DetectBalls detector;
  for (int i = 0; i < 10; ++i) {
    drawn.expose_again();
    FrameInfo info;
    info.times.t_capture_s = 100 + i / 60.0;
    const RegionList& regions = drawn.regions();
    BallList out;
    detector.process({}, drawn.scene(), drawn.lut(), Mask(), info, drawn.image(), regions, {}, out);
    if (i == 0) {
      EXPECT_THAT(out.balls, SizeIs(3));
    }
    if (i < 5) continue;
    ASSERT_THAT(out.balls, SizeIs(2)) << i;
    for (const Ball& ball : out.balls) EXPECT_LT(ball.y_mm, 400);
  }
}

TEST(DetectBalls, AStickerOnARobotIsNoBall) {
  DrawnScene drawn;
  drawn.add_robot(Team::kBlue, 9, 1400, 300, 1);
  drawn.cover(1400 - 60 * std::cos(1), 300 - 60 * std::sin(1), 140, 12, paint_color(label::kOrange));
  expect_no_ball(drawn, "a sticker on a robot");
}

// ---- parameters

TEST(DetectBalls, TheBestOnesAreReported) {
  DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4));
  for (int i = 0; i < 6; ++i) drawn.add_ball(700 + 300.0 * i, 400);
  for (int i = 0; i < 3; ++i)  // parts of them are hidden
    drawn.cover(700 + 300.0 * i + 20, 400, 60, 12, {60, 60, 60});
  DetectBalls::Params params;
  params.min_confidence = 0;
  const auto all = drawn.balls(params).balls;
  ASSERT_GE(all.size(), 4U);
  double last = 1;
  for (const Ball& ball : all) {
    EXPECT_GE(ball.confidence, 0);
    EXPECT_LE(ball.confidence, last);
    last = ball.confidence;
  }
  params.max_balls = 3;
  const auto best = drawn.balls(params).balls;
  ASSERT_THAT(best, SizeIs(3));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(best[i].x_mm, all[i].x_mm);
    EXPECT_GT(best[i].x_mm, 1500) << "a ball that is half hidden comes before one that is not";
  }
}

TEST(DetectBalls, DropsBallsBelowTheMinimumConfidence) {
  DrawnScene drawn(plain_options(PixelFormat::kUyvy, 4));
  for (int i = 0; i < 4; ++i) drawn.add_ball(700 + 300.0 * i, 400);
  drawn.cover(700 + 20, 400, 60, 14, {60, 60, 60});
  DetectBalls::Params params;
  params.min_confidence = 0;
  const auto all = drawn.balls(params).balls;
  params.min_confidence = 1;
  EXPECT_THAT(drawn.balls(params).balls, IsEmpty());
  for (const Ball& ball : all) {
    params.min_confidence = ball.confidence;
    EXPECT_EQ(static_cast<std::ptrdiff_t>(drawn.balls(params).balls.size()),
              std::count_if(all.begin(), all.end(),
                            [&](const Ball& b) { return b.confidence >= ball.confidence; }));
  }
}

// ---- no colour, no calibration, odd images

TEST(DetectBalls, NothingWithoutACalibration) {
  DrawnScene drawn;
  drawn.add_ball(1500, 500);
  EXPECT_THAT(drawn.balls().balls, SizeIs(1));
  drawn.scene().camera.reset();
  EXPECT_THAT(drawn.balls().balls, IsEmpty());
}

TEST(DetectBalls, NothingInAPictureWithoutColours) {
  DrawnScene grey(plain_options(PixelFormat::kMono8)), colored;
  for (DrawnScene* drawn : {&grey, &colored}) drawn->add_ball(1500, 500);
  EXPECT_THAT(grey.balls().balls, IsEmpty());
  BallList out;
  DetectBalls().process({}, grey.scene(), grey.lut(), Mask(), {}, grey.image(), colored.regions(), {}, out);
  EXPECT_THAT(out.balls, IsEmpty());
}

/// Expects balls whose centres are `in_px` inside the image's border to be found correctly or not at all.
void expect_nothing_wrong_at_edge(double in_px, double within_mm) {
  for (const PixelFormat format : kColorFormats) {
    DrawnScene drawn(plain_options(format, 4));
    for (const double u : {in_px, 300.3, 779 - in_px}) {
      for (const double v : {in_px, 200.7, 579 - in_px}) {
        if (u == 300.3 && v == 200.7) continue;
        const auto p = drawn.scene().camera->unproject({u, v}, kBallMm);
        drawn.add_ball(p->x(), p->y());
      }
    }
    for (const Ball& ball : drawn.balls().balls) {
      double nearest_mm = 1e9;
      for (const SimulatedBall& other : drawn.things().balls)
        nearest_mm = std::min(nearest_mm, std::hypot(other.x_mm - ball.x_mm, other.y_mm - ball.y_mm));
      EXPECT_LT(nearest_mm, within_mm) << name_of(format) << " " << in_px << " px inside, at " << ball.x_mm
                                       << ", " << ball.y_mm << " confidence " << ball.confidence;
    }
  }
}

TEST(DetectBalls, AtThePicturesVeryEdge) {
  for (const double in_px : {1.0, 2.5, 4.0}) expect_nothing_wrong_at_edge(in_px, 3);
}

TEST(DetectBalls, HalfOutOfThePicture) {
  for (const double in_px : {-3.0, -2.0, -1.0, 0.0}) expect_nothing_wrong_at_edge(in_px, 6);
}

TEST(DetectBalls, APictureOfAnotherSizeThanTheCalibrationsIsSurvived) {
  for (const PixelFormat format : kColorFormats) {
    SimulatorOptions options = plain_options(format);
    options.width = 390, options.height = 290;
    DrawnScene small(options), large(plain_options(format));
    for (DrawnScene* drawn : {&small, &large}) {
      for (int i = 0; i < 10; ++i) drawn->add_ball(100 + 300.0 * i, 1500 - 300.0 * i);
    }
    BallList out;
    DetectBalls().process({}, small.scene(), small.lut(), Mask(), {}, small.image(), large.regions(), {},
                          out);
    EXPECT_LE(out.balls.size(), 10U);
  }
}

// As dense as possible without being cut as a flood.
TEST(DetectBalls, ThousandsOfOrangeBlobsEndAndAllocateNothing) {
  DrawnScene drawn;
  std::mt19937 random(1);
  std::vector<std::uint8_t> bytes(780 * 580 * 3);
  constexpr std::array kLabels{label::kOrange, label::kOrange, label::kYellow, label::kPink, label::kField};
  for (std::size_t y = 0; y + 4 <= 580; y += 8) {
    for (std::size_t x = 0; x < 780; x += 8) {
      const Rgb c = paint_color(kLabels[random() % kLabels.size()]);
      for (std::size_t i = 0; i < 16; ++i) {
        std::uint8_t* out = bytes.data() + ((y + i / 4) * 780 + x + i % 4) * 3;
        out[0] = c.r, out[1] = c.g, out[2] = c.b;
      }
    }
  }
  const Image image({bytes.data(), 780, 580, 780 * 3, PixelFormat::kRgb24}, nullptr, nullptr, nullptr);
  RunList runs;
  RegionList regions;
  Segment().process({}, drawn.lut(), Mask(), image, runs, regions);
  ASSERT_GT(regions.of(label::kOrange).size(), 500U);
  DetectBalls detector;
  DetectBalls::Params params;
  params.max_fits = 100;
  BallList out;
  const Mask mask;
  detector.process(params, drawn.scene(), drawn.lut(), mask, {}, image, regions, {}, out);
  EXPECT_TRUE(out.capped);
  const std::uint64_t before = allocation_count();
  detector.process(params, drawn.scene(), drawn.lut(), mask, {}, image, regions, {}, out);
  if (counts_allocations()) {
    EXPECT_EQ(allocation_count() - before, 0U);
  }
}

}  // namespace
}  // namespace sslv::detect_balls_test
