// SPDX-License-Identifier: Apache-2.0
#include "vision/ball_memory.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace sslv {
namespace {

constexpr double kFrameS = 1.0 / 60;

TEST(BallMemory, WhatStandsOffTheFieldIsFurniture) {
  BallMemory memory;
  int reported = 0;
  for (int i = 0; i < 20; ++i) {
    memory.begin(10 + i * kFrameS);
    if (!memory.see(3000 + i % 3, 200 - i % 2, 150).as_furniture) ++reported;
  }
  EXPECT_LE(reported, 3);
  // Seen now and then only, as the light has it.
  memory.begin(30);
  EXPECT_TRUE(memory.see(3001, 200, 150).as_furniture);
  memory.begin(200);
  EXPECT_FALSE(memory.see(3001, 200, 150).as_furniture) << "long ago";
}

TEST(BallMemory, TellsWhatRestsFromWhatMoves) {
  BallMemory memory;
  for (int i = 0; i < 10; ++i) {
    memory.begin(10 + i * kFrameS);
    EXPECT_EQ(memory.see(i % 3, 200, -1000).at_rest, i > 0) << i;
    EXPECT_FALSE(memory.see(500 + 30 * i, -900, -1000).at_rest) << i;
  }
  // Twice in one picture is no rest.
  memory.begin(20);
  EXPECT_FALSE(memory.see(2000, 0, -1000).at_rest);
  EXPECT_FALSE(memory.see(2001, 0, -1000).at_rest);
}

TEST(BallMemory, WhatLiesOnTheFieldOrAtItsLinesIsABall) {
  BallMemory memory;
  for (int i = 0; i < 100; ++i) {
    memory.begin(10 + i * kFrameS);
    EXPECT_FALSE(memory.see(0, 0, -2000).as_furniture);
    EXPECT_FALSE(memory.see(3000, 0, 40).as_furniture);
  }
}

TEST(BallMemory, ABallThatRollsOutStaysOne) {
  BallMemory memory;
  for (int i = 0; i < 200; ++i) {
    memory.begin(10 + i * kFrameS);
    const double x_mm = std::min(3200.0, 2700 + 25.0 * i);
    EXPECT_FALSE(memory.see(x_mm, 500, x_mm - 3000).as_furniture) << i;
    memory.see(3150, -900, 150);  // furniture
  }
}

TEST(BallMemory, ABallThatRollsInFromOutsideIsOne) {
  BallMemory memory;
  for (int i = 0; i < 200; ++i) {
    memory.begin(10 + i * kFrameS);
    const double x_mm = std::max(3150.0, 4000 - 30.0 * i);
    EXPECT_FALSE(memory.see(x_mm, 500, x_mm - 3000).as_furniture) << i;
  }
}

TEST(BallMemory, TimeThatGoesBackForgetsAll) {
  BallMemory memory;
  for (int i = 0; i < 5; ++i) {
    memory.begin(10 + i);
    memory.see(3000, 0, 200);
  }
  memory.begin(16);
  EXPECT_TRUE(memory.see(3000, 0, 200).as_furniture);
  memory.begin(1);
  EXPECT_FALSE(memory.see(3000, 0, 200).as_furniture);
}

TEST(BallMemory, ManyThingsAreBounded) {
  BallMemory memory;
  for (int round = 0; round < 10; ++round) {
    memory.begin(10 + round);
    for (int i = 0; i < 500; ++i) memory.see(3100 + 20.0 * i, 0, 100 + 20.0 * i);
  }
  for (int i = 0; i < 10; ++i) {
    memory.begin(30 + i);
    memory.see(3100, 700, 100);
  }
  EXPECT_TRUE(memory.see(3100, 700, 100).as_furniture);
}

}  // namespace
}  // namespace sslv
