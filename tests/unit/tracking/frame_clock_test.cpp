// SPDX-License-Identifier: Apache-2.0
#include "tracking/frame_clock.h"

#include "halls/chance.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::frame_clock_test {
namespace {

constexpr double kPeriod_s = 1 / 75.0, kJitter_s = 0.2e-3;

/// Largest error after the first second, in s.
double worst_error(FrameClock& clock, halls::Chance& chance, double from_s, int images,
                   double missing_share = 0) {
  double worst_s = 0;
  for (int i = 0; i < images; ++i) {
    if (chance.happens(missing_share)) continue;
    const double t_s = from_s + i * kPeriod_s;
    const double off_s = clock.time_of(t_s + kJitter_s * chance.normal()) - t_s;
    if (i > 75) worst_s = std::max(worst_s, std::abs(off_s));
  }
  return worst_s;
}

TEST(FrameClock, TakesMostOfTheJitterOff) {
  halls::Chance chance(1, "clock");
  FrameClock clock;
  EXPECT_LT(worst_error(clock, chance, 1e9, 3000), 0.6 * kJitter_s);
  EXPECT_NEAR(clock.jitter_s(), kJitter_s, 0.3 * kJitter_s);
  EXPECT_LT(clock.sigma_s(), 0.2 * kJitter_s);
}

TEST(FrameClock, KnowsHowManyImagesAreMissing) {
  halls::Chance chance(2, "clock");
  FrameClock clock;
  EXPECT_LT(worst_error(clock, chance, 1e9, 3000, 0.3), kJitter_s);
}

TEST(FrameClock, FollowsAnotherRate) {
  FrameClock clock;
  double t_s = 1e9;
  for (int i = 0; i < 300; ++i) clock.time_of(t_s += kPeriod_s);
  double off_s = 1;
  for (int i = 0; i < 300; ++i) {
    t_s += kPeriod_s * 1.02;
    off_s = clock.time_of(t_s) - t_s;
  }
  EXPECT_NEAR(off_s, 0, 0.1e-3);
}

TEST(FrameClock, StartsAgainWhereStampsJump) {
  halls::Chance chance(3, "clock");
  FrameClock clock;
  worst_error(clock, chance, 1e9, 300);
  for (const double from_s : {1e9 + 3600, 1e9 - 3600, 1e9 + 0.4}) {
    EXPECT_NEAR(clock.time_of(from_s), from_s, 1e-6);
    EXPECT_LT(worst_error(clock, chance, from_s + kPeriod_s, 1000), 0.7 * kJitter_s) << from_s;
  }
}

}  // namespace
}  // namespace sslv::frame_clock_test
