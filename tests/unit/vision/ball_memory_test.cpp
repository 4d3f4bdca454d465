// SPDX-License-Identifier: Apache-2.0
#include "vision/ball_memory.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace sslv::ball_memory_test {
namespace {

constexpr double kFrameS = 1.0 / 60;
constexpr BallMemory::Color kOrange{140, 70, 30}, kRed{140, 40, 35}, kSunny{190, 115, 60};
constexpr double kRound = 0.5, kSquare = 1.5;

BallMemory::Known see(BallMemory& memory, double x_mm, double y_mm, double outside_mm) {
  return memory.see(x_mm, y_mm, outside_mm, kOrange, kRound, true);
}

/// Balls at other places in each image, as in play.
void let_balls_move(BallMemory& memory, int picture) {
  memory.see(-3000 + 400 * picture, 1000, -1000, kOrange, kRound, true);
  memory.see(-3000 + 400 * picture, -1000, -1000, kOrange, kRound, true);
}

TEST(BallMemory, AStandingThingOffTheFieldIsFurniture) {
  BallMemory memory;
  int reported = 0;
  for (int i = 0; i < 20; ++i) {
    memory.begin(10 + i * kFrameS);
    if (!see(memory, 3000 + i % 3, 200 - i % 2, 150).as_furniture) ++reported;
  }
  EXPECT_LE(reported, 3);
  // Then it is found only sometimes, depending on the light.
  memory.begin(30);
  EXPECT_TRUE(see(memory, 3001, 200, 150).as_furniture);
  memory.begin(200);
  EXPECT_FALSE(see(memory, 3001, 200, 150).as_furniture) << "long ago";
}

TEST(BallMemory, DistinguishesRestFromMotion) {
  BallMemory memory;
  for (int i = 0; i < 10; ++i) {
    memory.begin(10 + i * kFrameS);
    EXPECT_EQ(see(memory, i % 3, 200, -1000).at_rest, i > 0) << i;
    EXPECT_FALSE(see(memory, 500 + 30 * i, -900, -1000).at_rest) << i;
  }
  // Two balls in one image are not one at rest.
  memory.begin(20);
  EXPECT_FALSE(see(memory, 2000, 0, -1000).at_rest);
  EXPECT_FALSE(see(memory, 2001, 0, -1000).at_rest);
}

TEST(BallMemory, AThingOnTheFieldOrItsLinesIsNoFurniture) {
  BallMemory memory;
  for (int i = 0; i < 100; ++i) {
    memory.begin(10 + i * kFrameS);
    EXPECT_FALSE(see(memory, 0, 0, -2000).as_furniture);
    EXPECT_FALSE(see(memory, 3000, 0, 40).as_furniture);
  }
}

TEST(BallMemory, ABallThatRollsOutIsNoFurniture) {
  BallMemory memory;
  for (int i = 0; i < 200; ++i) {
    memory.begin(10 + i * kFrameS);
    const double x_mm = std::min(3200.0, 2700 + 25.0 * i);
    EXPECT_FALSE(see(memory, x_mm, 500, x_mm - 3000).as_furniture) << i;
    see(memory, 3150, -900, 150);  // furniture
  }
}

TEST(BallMemory, ABallThatRollsInIsNoFurniture) {
  BallMemory memory;
  for (int i = 0; i < 200; ++i) {
    memory.begin(10 + i * kFrameS);
    const double x_mm = std::max(3150.0, 4000 - 30.0 * i);
    EXPECT_FALSE(see(memory, x_mm, 500, x_mm - 3000).as_furniture) << i;
  }
}

TEST(BallMemory, TimeThatGoesBackForgetsAll) {
  BallMemory memory;
  for (int i = 0; i < 5; ++i) {
    memory.begin(10 + i);
    see(memory, 3000, 0, 200);
  }
  memory.begin(16);
  EXPECT_TRUE(see(memory, 3000, 0, 200).as_furniture);
  memory.begin(1);
  EXPECT_FALSE(see(memory, 3000, 0, 200).as_furniture);
}

TEST(BallMemory, AThingOfAnotherHueThatNeverMovedIsNoBall) {
  BallMemory memory;
  int tape = 0, dimmer_tape = 0;
  for (int i = 0; i < 15; ++i) {
    memory.begin(10 + i * kFrameS);
    let_balls_move(memory, i);
    if (!memory.see(0, 200, -100, kRed, kRound, true).unlike_balls) ++tape;
    if (!memory.see(500, 200, -100, {70, 20, 17.5}, kRound, false).unlike_balls) ++dimmer_tape;
    EXPECT_FALSE(memory.see(1000, 200, -100, kOrange, kRound, true).unlike_balls) << "a ball that lies there";
    EXPECT_FALSE(memory.see(1500, 200, -100, {255, 40, 35}, kRound, true).unlike_balls)
        << "its red is clipped";
  }
  EXPECT_LE(tape, 4);
  EXPECT_EQ(tape, dimmer_tape);
  // It is remembered even when hidden for long.
  memory.begin(1000);
  EXPECT_TRUE(memory.see(0, 200, -100, kRed, kRound, true).unlike_balls);
}

TEST(BallMemory, ALessRoundThingThatNeverMovedIsNoBallAfterAWhile) {
  BallMemory memory;
  for (int i = 0; i < 20; ++i) {
    const double since_s = 3.0 * i;
    memory.begin(10 + since_s);
    let_balls_move(memory, i);
    // Noise makes an image of tape as round as a ball now and then, and a ball as square as tape.
    const bool is_odd = i % 4 == 1;
    const auto tape = memory.see(0, 200, -100, kOrange, is_odd ? kRound : kSquare, true);
    EXPECT_EQ(tape.unlike_balls, since_s >= 30) << since_s;
    EXPECT_FALSE(memory.see(500, 200, -100, kOrange, is_odd ? kSquare : kRound, true).unlike_balls);
  }
}

TEST(BallMemory, FewBallsOrBallsThatDifferWidelyDoNotTeachTheOutline) {
  BallMemory few, differ;
  for (int i = 0; i < 20; ++i) {
    few.begin(10 + 3.0 * i);
    few.see(-3000 + 400 * std::min(i, 9), 1000, -1000, kOrange, kRound, true);  // nine places, then it rests
    EXPECT_FALSE(few.see(0, 200, -100, kOrange, kSquare, true).unlike_balls) << i;
    differ.begin(10 + 3.0 * i);
    differ.see(-3000 + 400 * i, 1000, -1000, kOrange, kRound + 0.3 * (i % 5), true);
    EXPECT_FALSE(differ.see(0, 200, -100, kOrange, kSquare, true).unlike_balls) << i;
  }
}

TEST(BallMemory, ALessRoundThingThatMovedOrAppearedLaterIsABall) {
  BallMemory memory;
  for (int i = 0; i < 60; ++i) {
    memory.begin(10 + 3.0 * i);
    let_balls_move(memory, i % 15);
    if (i <= 5) continue;
    EXPECT_FALSE(memory.see(500, 200, -100, kOrange, kSquare, true).unlike_balls) << "laid there";
  }
}

TEST(BallMemory, ConfidenceOverTime) {
  BallMemory memory;
  double now_s = 10;
  const auto rate = [&](double x_mm, double confidence) {
    now_s += kFrameS;
    memory.begin(now_s);
    return memory.over_time(see(memory, x_mm, 0, -1000).number, confidence);
  };
  const auto rate_often = [&](double x_mm, double confidence) {
    for (int i = 0; i < 20; ++i) rate(x_mm, confidence);
  };
  EXPECT_NEAR(rate(0, 0.99), 0.99, 1e-9);
  EXPECT_NEAR(rate(0, 0.3), 0.3, 1e-9) << "it may be fixed there";
  rate_often(0, 0.01);
  EXPECT_LT(rate(0, 0.6), 0.5) << "tape in an image in which it resembles a ball";
  EXPECT_GT(rate(0, 0.99), 0.5) << "a ball that a robot uncovers";

  rate_often(20, 0.99);
  EXPECT_GT(rate(70, 0.3), 0.5) << "a ball that begins to move, in a poor image";
  EXPECT_GT(rate(150, 0.3), 0.5) << "faster";
  EXPECT_LT(rate(70, 0.3), 0.5) << "something else, near a ball that is hidden";

  now_s += 20;
  rate_often(1000, 0.9999);
  EXPECT_GT(rate(1000, 0.3), 0.5) << "a ball that was put there, in a poor image";
  rate_often(1000, 0.9999);
  int images = 0;
  while (rate(1000, 0.1) > 0.5) ++images;
  EXPECT_LE(images, 5) << "a ball that was replaced by something else";
  now_s += 1;
  EXPECT_NEAR(rate(1000, 0.3), 0.3, 1e-9) << "a second later";
  EXPECT_GE(rate(1000, 0), 0);
  EXPECT_LE(rate(1000, 1), 1);
}

TEST(BallMemory, StandingThingsDoNotTeachTheHue) {
  BallMemory memory;
  for (int i = 0; i < 50; ++i) {
    memory.begin(10 + i * kFrameS);
    for (int k = 0; k < 8; ++k) memory.see(400 * k, 200, -100, kRed, kRound, true);
    EXPECT_FALSE(memory.see(0, 1000, -1000, kOrange, kRound, true).unlike_balls)
        << "eight pieces of tape, one ball";
  }
}

TEST(BallMemory, AThingThatMovedOrAppearedLaterIsABallOfAnyHue) {
  BallMemory memory;
  for (int i = 0; i < 1200; ++i) {
    memory.begin(10 + i * kFrameS);
    let_balls_move(memory, i % 15);
    const double x_mm = std::min(2000.0, 30.0 * i);
    EXPECT_FALSE(memory.see(x_mm, -200, -100, kSunny, kRound, true).unlike_balls)
        << "rolls into the sun, and rests";
    if (i <= 700) continue;
    EXPECT_FALSE(memory.see(500, 200, -100, kSunny, kRound, true).unlike_balls) << "laid there";
  }
}

TEST(BallMemory, ManyThingsAreBounded) {
  BallMemory memory;
  for (int round = 0; round < 10; ++round) {
    memory.begin(10 + round);
    for (int i = 0; i < 500; ++i) see(memory, 3100 + 20.0 * i, 0, 100 + 20.0 * i);
  }
  for (int i = 0; i < 10; ++i) {
    memory.begin(30 + i);
    see(memory, 3100, 700, 100);
  }
  EXPECT_TRUE(see(memory, 3100, 700, 100).as_furniture);
}

}  // namespace
}  // namespace sslv::ball_memory_test
