// SPDX-License-Identifier: Apache-2.0
#include "vision/ball_memory.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace sslv::ball_memory_test {
namespace {

constexpr double kFrameS = 1.0 / 60;
constexpr BallMemory::Color kOrange{140, 70, 30}, kRed{140, 40, 35}, kSunny{190, 115, 60};
constexpr double kRound = 0.5, kSquare = 1.5;

BallMemory::Known see(BallMemory& memory, const BallMemory::Object& object) {
  const auto known = memory.see_again(object);
  return known ? *known : memory.see_elsewhere(object);
}
BallMemory::Known see(BallMemory& memory, double x_mm, double y_mm, double outside_mm) {
  return see(memory, {x_mm, y_mm, outside_mm, kOrange, kRound, true});
}

/// Balls at other places in each image, as in play.
void let_balls_move(BallMemory& memory, int picture) {
  see(memory, {-3000 + 400.0 * picture, 1000, -1000, kOrange, kRound, true});
  see(memory, {-3000 + 400.0 * picture, -1000, -1000, kOrange, kRound, true});
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
    if (!see(memory, {0, 200, -100, kRed, kRound, true}).unlike_balls) ++tape;
    if (!see(memory, {500, 200, -100, {70, 20, 17.5}, kRound, false}).unlike_balls) ++dimmer_tape;
    EXPECT_FALSE(see(memory, {1000, 200, -100, kOrange, kRound, true}).unlike_balls)
        << "a ball that lies there";
    EXPECT_FALSE(see(memory, {1500, 200, -100, {255, 40, 35}, kRound, true}).unlike_balls)
        << "its red is clipped";
  }
  EXPECT_LE(tape, 4);
  EXPECT_EQ(tape, dimmer_tape);
  // It is remembered even when hidden for long.
  memory.begin(1000);
  EXPECT_TRUE(see(memory, {0, 200, -100, kRed, kRound, true}).unlike_balls);
}

TEST(BallMemory, ALessRoundThingThatNeverMovedIsNoBallAfterAWhile) {
  BallMemory memory;
  for (int i = 0; i < 20; ++i) {
    const double since_s = 3.0 * i;
    memory.begin(10 + since_s);
    let_balls_move(memory, i);
    // Noise makes an image of tape as round as a ball now and then, and a ball as square as tape.
    const bool is_odd = i % 4 == 1;
    const auto tape = see(memory, {0, 200, -100, kOrange, is_odd ? kRound : kSquare, true});
    EXPECT_EQ(tape.unlike_balls, since_s >= 30) << since_s;
    EXPECT_FALSE(see(memory, {500, 200, -100, kOrange, is_odd ? kSquare : kRound, true}).unlike_balls);
  }
}

TEST(BallMemory, FewBallsOrBallsThatDifferWidelyDoNotTeachTheOutline) {
  BallMemory few, differ;
  for (int i = 0; i < 20; ++i) {
    few.begin(10 + 3.0 * i);
    see(few,
        {-3000 + 400.0 * std::min(i, 9), 1000, -1000, kOrange, kRound, true});  // nine places, then it rests
    EXPECT_FALSE(see(few, {0, 200, -100, kOrange, kSquare, true}).unlike_balls) << i;
    differ.begin(10 + 3.0 * i);
    see(differ, {-3000 + 400.0 * i, 1000, -1000, kOrange, kRound + 0.3 * (i % 5), true});
    EXPECT_FALSE(see(differ, {0, 200, -100, kOrange, kSquare, true}).unlike_balls) << i;
  }
}

TEST(BallMemory, ALessRoundThingThatMovedOrAppearedLaterIsABall) {
  BallMemory memory;
  for (int i = 0; i < 60; ++i) {
    memory.begin(10 + 3.0 * i);
    let_balls_move(memory, i % 15);
    if (i <= 5) continue;
    EXPECT_FALSE(see(memory, {500, 200, -100, kOrange, kSquare, true}).unlike_balls) << "laid there";
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

TEST(BallMemory, ConfidenceBelongsToOneObject) {
  BallMemory memory;
  memory.begin(1);
  see(memory, 3000, 0, -1000);
  for (int i = 0; i < 20; ++i) {
    memory.begin(20 + i * kFrameS);
    memory.over_time(see(memory, 0, 0, -1000).number, 0.9999);
  }
  // Something larger appears beside the resting ball, so its region is the first in the list.
  memory.begin(20.4);
  const BallMemory::Object ball{0, 0, -1000, kOrange, kRound, true},
      other{50, 0, -1000, kOrange, kRound, true};
  const auto known = memory.see_again(ball);
  ASSERT_TRUE(known);
  EXPECT_FALSE(memory.see_again(other));
  EXPECT_NEAR(memory.over_time(memory.see_elsewhere(other).number, 0.1), 0.1, 1e-9);
  EXPECT_GT(memory.over_time(known->number, 0.1), 0.5);
  // More objects than are remembered.
  memory.begin(20.5);
  for (int i = 0; i < 200; ++i) {
    const double confidence = i % 2 == 0 ? 0.99 : 0.02;
    EXPECT_NEAR(memory.over_time(see(memory, 500 + 200.0 * i, 0, -1000).number, confidence), confidence,
                1e-9);
  }
}

TEST(BallMemory, ImagesOfTheSameTimeAreHarmless) {
  BallMemory memory;
  for (int i = 0; i < 10; ++i) {
    memory.begin(10);
    EXPECT_NEAR(memory.over_time(see(memory, 0, 0, -1000).number, 0.3), 0.3, 1e-9);
  }
}

TEST(BallMemory, AFixedThingThatSeldomResemblesABallIsNone) {
  BallMemory memory;
  int reported = 0;
  for (int i = 0; i < 40; ++i) {
    memory.begin(10 + i * kFrameS);
    if (i % 4 == 0 && memory.over_time(see(memory, 0, 0, -1000).number, 0.7) > 0.5) ++reported;
  }
  EXPECT_LE(reported, 1);
}

/// Tape that lies at (0, 200) since the beginning, and balls that have moved.
BallMemory with_tape(int images = 20) {
  BallMemory memory;
  for (int i = 0; i < images; ++i) {
    memory.begin(10 + i);
    let_balls_move(memory, i);
    see(memory, {0, 200, -100, kRed, kRound, true});
  }
  return memory;
}

TEST(BallMemory, TapeThatARobotHidesInPartIsStillTape) {
  BallMemory memory = with_tape();
  for (int i = 0; i < 10; ++i) {
    memory.begin(30 + i * kFrameS);
    const double shift_mm = 13.0 * (i % 4);
    EXPECT_TRUE(see(memory, {shift_mm, 200, -100, kRed, kRound, true}).unlike_balls) << i;
  }
}

TEST(BallMemory, ABallThatPassesTapeIsStillABallAndTheTapeTape) {
  BallMemory memory = with_tape();
  for (int i = 0; i < 20; ++i) {
    memory.begin(30 + i * kFrameS);
    // The ball's larger region is the first in the list, and hides the tape for some images.
    const BallMemory::Object ball{-500 + 50.0 * i, 215, -100, kOrange, kRound, true};
    EXPECT_FALSE(see(memory, ball).unlike_balls) << i;
    if (i >= 9 && i <= 11) continue;
    EXPECT_TRUE(see(memory, {0, 200, -100, kRed, kRound, true}).unlike_balls) << i;
  }
}

TEST(BallMemory, TheBeginningIsThatOfTheFirstObjects) {
  BallMemory memory;
  for (int i = 0; i < 100; ++i) memory.begin(10 + i);  // no colours have been learnt yet
  for (int i = 0; i < 15; ++i) {
    memory.begin(110 + i * kFrameS);
    let_balls_move(memory, i);
    const bool unlike = see(memory, {0, 200, -100, kRed, kRound, true}).unlike_balls;
    if (i == 3) continue;
    EXPECT_EQ(unlike, i > 3) << i;
  }
  // After a calibration the tape is elsewhere.
  memory.forget_places();
  for (int i = 0; i < 3; ++i) {
    memory.begin(111 + i * kFrameS);
    EXPECT_EQ(see(memory, {70, 250, -100, kRed, kRound, true}).unlike_balls, i > 0) << i;
  }
}

TEST(BallMemory, ABallThatComesToRestWhereTapeWasIsABallAfterAWhile) {
  BallMemory memory = with_tape();
  int images = 0;
  do {
    ++images;
    memory.begin(30 + images * kFrameS);
  } while (see(memory, {0, 200, -100, kOrange, kRound, true}).unlike_balls && images < 10'000);
  EXPECT_LT(images, 1000);
}

TEST(BallMemory, StandingThingsDoNotTeachTheHue) {
  BallMemory memory;
  for (int i = 0; i < 50; ++i) {
    memory.begin(10 + i * kFrameS);
    for (int k = 0; k < 8; ++k) see(memory, {400.0 * k, 200, -100, kRed, kRound, true});
    EXPECT_FALSE(see(memory, {0, 1000, -1000, kOrange, kRound, true}).unlike_balls)
        << "eight pieces of tape, one ball";
  }
}

TEST(BallMemory, AThingThatMovedOrAppearedLaterIsABallOfAnyHue) {
  BallMemory memory;
  for (int i = 0; i < 1200; ++i) {
    memory.begin(10 + i * kFrameS);
    let_balls_move(memory, i % 15);
    const double x_mm = std::min(2000.0, 30.0 * i);
    EXPECT_FALSE(see(memory, {x_mm, -200, -100, kSunny, kRound, true}).unlike_balls)
        << "rolls into the sun, and rests";
    if (i <= 700) continue;
    EXPECT_FALSE(see(memory, {500, 200, -100, kSunny, kRound, true}).unlike_balls) << "laid there";
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
