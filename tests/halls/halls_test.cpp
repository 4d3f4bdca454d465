// SPDX-License-Identifier: Apache-2.0
// Checks the renderer's ground truth: objects are drawn where it states them.

#include "camera_bytes.h"
#include "draw.h"
#include "hall.h"
#include "play.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::halls {
namespace {

/// A hall with everything needed to draw it.
struct Drawn {
  explicit Drawn(const HallOptions& options, const PlayOptions& play = {})
      : hall(make_hall(options)),
        camera(hall.calibration),
        painter(hall, camera),
        obstacles(camera, painter.obstacles()),
        game(hall, camera, obstacles, play) {}
  Hall hall;
  CameraModel camera;
  Painter painter;
  Obstacles obstacles;
  Game game;
};

/// Centroid of the brightness above the local minimum, within `reach_px` of a place.
Eigen::Vector2d center_of_light(Picture& picture, const Eigen::Vector2d& around, double reach_px) {
  double least = 1e9;
  for (const bool first : {true, false}) {
    double sum = 0;
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();
    for (int y = static_cast<int>(around.y() - reach_px); y <= around.y() + reach_px; ++y) {
      for (int x = static_cast<int>(around.x() - reach_px); x <= around.x() + reach_px; ++x) {
        if (std::hypot(x - around.x(), y - around.y()) > reach_px) continue;
        const double light = picture.row(y)[static_cast<std::size_t>(x)].sum();
        if (first) {
          least = std::min(least, light);
        } else {
          sum += light - least;
          moment += (light - least) * Eigen::Vector2d(x, y);
        }
      }
    }
    if (!first) return moment / sum;
  }
  return around;
}

TEST(Halls, DotsLieWhereTheTruthSaysThatTheyAre) {
  HallOptions options;
  options.kind = Kind::kAcceptance;
  options.uneven = options.vignette = 0;  // a brightness gradient across a dot would shift its centroid
  Drawn drawn(options);
  for (int frame = 1; frame <= 3; ++frame) {
    const Play play = drawn.game.at(frame);
    Picture picture = drawn.painter.frame(play, frame, 1);
    int seen = 0;
    for (const PlayedRobot& robot : play.robots) {
      if (robot.share < 1) continue;
      const Eigen::Vector3d center(robot.solid.at_mm().x(), robot.solid.at_mm().y(),
                                   robot.solid.look().height_mm);
      const Eigen::Vector2d truth = drawn.camera.project(center).value();
      const double px_per_mm = 1 / std::sqrt(drawn.camera.mm2_per_px(truth, center.z()));
      // The centre dot ends at a radius of 25 mm; the next dots begin at 45 mm.
      const Eigen::Vector2d found = center_of_light(picture, truth, 35 * px_per_mm);
      EXPECT_LT((found - truth).norm(), 0.02) << "frame " << frame << ", id " << robot.id;
      ++seen;
    }
    EXPECT_GT(seen, 6);
  }
}

TEST(Halls, AFrameIsTheSameWhicheverWereDrawnBefore) {
  HallOptions options;
  options.kind = Kind::kHard;
  Drawn one(options), other(options);
  one.painter.frame(one.game.at(1), 1, 0.8);
  const auto bytes = [](Drawn& drawn) {
    const Picture picture = drawn.painter.frame(drawn.game.at(2), 2, 1);
    return camera_bytes(picture, drawn.hall.sensor, PixelFormat::kUyvy, Chance(1, "noise"));
  };
  EXPECT_EQ(bytes(one), bytes(other));
}

TEST(Halls, OnlyHardHallsHideBallsAndObstaclesKeepBallsFree) {
  for (const Kind kind : {Kind::kUsual, Kind::kHard}) {
    HallOptions options;
    options.kind = kind;
    PlayOptions play_options;
    play_options.balls = 4;
    const Drawn drawn(options, play_options);
    int hidden = 0;
    for (int frame = 1; frame <= 10; ++frame) {
      for (const PlayedBall& ball : drawn.game.at(frame).balls) {
        EXPECT_TRUE(drawn.obstacles.leave_free(ball.at_mm, Ball::kRadiusMm, 2 * Ball::kRadiusMm));
        EXPECT_GE(ball.share, kind == Kind::kHard ? 0.4 : 1.0);
        if (ball.share < 1) ++hidden;
      }
    }
    EXPECT_EQ(hidden > 0, kind == Kind::kHard);
  }
}

TEST(Halls, WhatMovesIsSmearedAroundItsTruth) {
  HallOptions options;
  options.kind = Kind::kAcceptance;
  options.exposure_s = 0.008;
  PlayOptions play_options;
  play_options.speed_mm_s = 2000;
  Drawn drawn(options, play_options);
  const Play play = drawn.game.at(1);
  Picture picture = drawn.painter.frame(play, 1, 1);
  for (const PlayedRobot& robot : play.robots) {
    if (robot.share < 1) continue;
    const Eigen::Vector3d center(robot.solid.at_mm().x(), robot.solid.at_mm().y(),
                                 robot.solid.look().height_mm);
    const Eigen::Vector2d truth = drawn.camera.project(center).value();
    const double px_per_mm = 1 / std::sqrt(drawn.camera.mm2_per_px(truth, center.z()));
    EXPECT_LT((center_of_light(picture, truth, 35 * px_per_mm) - truth).norm(), 0.1) << robot.id;
  }
}

}  // namespace
}  // namespace sslv::halls
