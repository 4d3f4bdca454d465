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
    if (!memory.see(3000 + i % 3, 200 - i % 2, 150)) ++reported;
  }
  EXPECT_LE(reported, 3);
  // Seen now and then only, as the light has it.
  memory.begin(30);
  EXPECT_TRUE(memory.see(3001, 200, 150));
  memory.begin(200);
  EXPECT_FALSE(memory.see(3001, 200, 150)) << "long ago";
}

TEST(BallMemory, WhatLiesOnTheFieldOrAtItsLinesIsABall) {
  BallMemory memory;
  for (int i = 0; i < 100; ++i) {
    memory.begin(10 + i * kFrameS);
    EXPECT_FALSE(memory.see(0, 0, -2000));
    EXPECT_FALSE(memory.see(3000, 0, 40));
  }
}

TEST(BallMemory, ABallThatRollsOutStaysOne) {
  BallMemory memory;
  for (int i = 0; i < 200; ++i) {
    memory.begin(10 + i * kFrameS);
    const double x_mm = std::min(3200.0, 2700 + 25.0 * i);
    EXPECT_FALSE(memory.see(x_mm, 500, x_mm - 3000)) << i;
    memory.see(3150, -900, 150);  // furniture
  }
}

TEST(BallMemory, ABallThatRollsInFromOutsideIsOne) {
  BallMemory memory;
  for (int i = 0; i < 200; ++i) {
    memory.begin(10 + i * kFrameS);
    const double x_mm = std::max(3150.0, 4000 - 30.0 * i);
    EXPECT_FALSE(memory.see(x_mm, 500, x_mm - 3000)) << i;
  }
}

TEST(BallMemory, TimeThatGoesBackForgetsAll) {
  BallMemory memory;
  for (int i = 0; i < 5; ++i) {
    memory.begin(10 + i);
    memory.see(3000, 0, 200);
  }
  memory.begin(16);
  EXPECT_TRUE(memory.see(3000, 0, 200));
  memory.begin(1);
  EXPECT_FALSE(memory.see(3000, 0, 200));
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
  EXPECT_TRUE(memory.see(3100, 700, 100));
}

}  // namespace
}  // namespace sslv
