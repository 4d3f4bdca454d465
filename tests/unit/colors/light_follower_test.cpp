// SPDX-License-Identifier: Apache-2.0
#include "colors/light_follower.h"

#include "support/drawn_scene.h"

#include <array>
#include <cmath>
#include <memory>
#include <string>

#include <gmock/gmock.h>

namespace sslv::light_follower_test {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;

constexpr double kPeriodS = 0.2;

/// The centre of overhead_camera()'s image, half as wide and half as high, because drawing takes most of the
/// time.
CameraCalibration near_camera() {
  CameraCalibration c = overhead_camera();
  c.principal_point_x = 194.5, c.principal_point_y = 144.5;
  c.pixel_image_width = 390, c.pixel_image_height = 290;
  return c;
}

/// Six robots, a ball, and a table accepted in light 1.
class Hall {
 public:
  explicit Hall(PixelFormat format = PixelFormat::kUyvy)
      : format_(format), follower_(DrawnScene(plain_options(format)).lut_pointer()) {
    params_.enabled = true;
  }

  /// Shows the follower `pictures` images in a light. `more` adds things to each.
  template <class More>
  void look(double light, int pictures, const More& more) {
    SimulatorOptions options = plain_options(format_);
    options.width = 390, options.height = 290;
    options.light = light;
    options.gradient = gradient_;
    options.red_gain = cast_, options.blue_gain = 1 / cast_;
    options.noise_sigma = 3;
    DrawnScene drawn(options, near_camera());
    for (int i = 0; i < pictures; ++i, time_s_ += kPeriodS) {
      drawn.clear();
      drawn.use_lut(follower_.table());
      for (int k = 0; k < robots_; ++k) {
        drawn.add_robot(k % 2 == 0 ? Team::kYellow : Team::kBlue, k, 560 + 280.0 * k, -800 + 320.0 * k,
                        time_s_ + k);
      }
      drawn.add_ball(600, 500);
      more(drawn, i);
      found_ = drawn.robots().robots;
      balls_ = drawn.balls().balls.size();
      follower_.observe(params_, {time_s_, drawn.image().view(), drawn.scene(), league_patterns(), found_,
                                  game_is_running_});
      follower_.new_table();
    }
  }
  void look(double light, int pictures) {
    look(light, pictures, [](DrawnScene&, int) {});
  }
  const LightState& state() const { return follower_.state(); }

  PixelFormat format_;
  LightFollower follower_;
  FollowLightParams params_;
  double time_s_ = 100, gradient_ = 0, cast_ = 1;
  int robots_ = 6;
  bool game_is_running_ = false;
  std::vector<Robot> found_;
  std::size_t balls_ = 0;
};

void expect_gain(const LightState& state, double red, double green, double blue, double within) {
  const std::array expected{red, green, blue};
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(std::log(state.gain[c] / expected[c]), 0, within)
        << "channel " << c << ": " << state.gain[c] << " for " << expected[c] << ", "
        << name_of(state.following) << " " << state.why;
  }
}

TEST(LightFollower, FollowsTheLightDownAndUp) {
  for (const PixelFormat format : {PixelFormat::kUyvy, PixelFormat::kBayerRg8}) {
    Hall hall(format);
    hall.look(1, 4);
    expect_gain(hall.state(), 1, 1, 1, 0.03);
    EXPECT_EQ(hall.state().following, LightFollowing::kFollowing);
    for (const double light : {0.6, 0.35, 0.8, 1.6}) {
      hall.look(light, 3);
      expect_gain(hall.state(), light, light, light, 0.06);
      EXPECT_EQ(hall.found_.size(), 6u) << light;
      EXPECT_EQ(hall.balls_, 1u) << light;
      EXPECT_EQ(hall.state().robots, 6);
    }
    EXPECT_THAT(hall.follower_.steps(), testing::SizeIs(testing::Ge(4u)));
  }
}

TEST(LightFollower, FollowsItsColourSlowly) {
  Hall hall;
  hall.look(1, 4);
  hall.cast_ = 1.15;
  hall.look(1, 2);
  EXPECT_LT(hall.state().gain[0], 1.12);
  hall.look(1, 20);
  expect_gain(hall.state(), 1.15, 1, 1 / 1.15, 0.03);
  EXPECT_EQ(hall.found_.size(), 6u);
}

TEST(LightFollower, FreezesWithoutConfirmedRobots) {
  Hall hall;
  hall.look(1, 4);
  hall.robots_ = 1;
  hall.look(0.8, 20);
  expect_gain(hall.state(), 1, 1, 1, 0.03);
  EXPECT_EQ(hall.state().following, LightFollowing::kFrozen);
  EXPECT_EQ(hall.state().why, "1 of 2 robots are confirmed");
  EXPECT_NEAR(*hall.state().last_confirmed_s, 100.6, 1e-6);
  hall.robots_ = 0;  // a ball is there all the time
  hall.look(0.6, 20);
  expect_gain(hall.state(), 1, 1, 1, 0.03);
  EXPECT_EQ(hall.state().why, "no robot is confirmed");
}

// ---- wrong things

/// An orange shirt and a pink bag that move over part of the field and over robots, and a yellow card.
void wrong_things(DrawnScene& drawn, int i) {
  drawn.cover(900, -900 + 90.0 * i, 1500, 180, {238, 108, 32});
  drawn.cover_bar(1400, 700 - 60.0 * i, 1600, 700 - 60.0 * i, 900, 200, {230, 64, 150});
  drawn.add_thing(
      {SimulatedDistractor::Shape::kRectangle, label::kYellow, 1700, -600 + 40.0 * i, 0.3, 250, 180});
}

TEST(LightFollower, AShirtABagAndACardTeachNothing) {
  Hall hall;
  hall.look(1, 15, wrong_things);
  expect_gain(hall.state(), 1, 1, 1, 0.03);
  EXPECT_THAT(hall.state().areas, Each(testing::DoubleNear(1, 0.07)));
  EXPECT_EQ(hall.follower_.table(), hall.follower_.accepted());
  hall.look(0.6, 10, wrong_things);
  expect_gain(hall.state(), 0.6, 0.6, 0.6, 0.05);
}

TEST(LightFollower, WrongThingsAloneTeachNothing) {
  Hall hall;
  hall.look(1, 4);
  hall.robots_ = 0;
  hall.look(1, 12, wrong_things);
  expect_gain(hall.state(), 1, 1, 1, 0.03);
  EXPECT_EQ(hall.state().following, LightFollowing::kFrozen);
  EXPECT_FALSE(hall.state().from_carpet);
}

TEST(LightFollower, AShirtOverMostOfThePictureIsNoLight) {
  Hall hall;
  hall.look(1, 4);
  hall.look(1, 12, [](DrawnScene& drawn, int i) {
    drawn.cover(1250 + 10.0 * i, 0, 1500, 500, {238, 108, 32});
  });
  expect_gain(hall.state(), 1, 1, 1, 0.03);
  hall.look(1, 1);
  EXPECT_EQ(hall.found_.size(), 6u);
}

// ---- jumps

TEST(LightFollower, AJumpThatLosesAllRobotsIsTriedFromTheCarpet) {
  Hall hall;
  hall.look(1, 4);
  hall.look(0.33, 1);
  EXPECT_TRUE(hall.found_.empty()) << "or this test shows nothing";
  EXPECT_TRUE(hall.state().from_carpet);
  expect_gain(hall.state(), 0.33, 0.33, 0.33, 0.15);
  hall.look(0.33, 4);
  EXPECT_EQ(hall.found_.size(), 6u);
  EXPECT_FALSE(hall.state().from_carpet);
  expect_gain(hall.state(), 0.33, 0.33, 0.33, 0.06);
  EXPECT_EQ(hall.state().following, LightFollowing::kFollowing);
}

TEST(LightFollower, ChangesFromTheCarpetAreRevertedUnlessRobotsConfirm) {
  Hall hall;
  hall.look(1, 4);
  hall.robots_ = 0;
  hall.look(0.33, 1);
  EXPECT_TRUE(hall.state().from_carpet);
  hall.look(0.33, 20);
  EXPECT_FALSE(hall.state().from_carpet);
  expect_gain(hall.state(), 1, 1, 1, 0.03);
  EXPECT_EQ(hall.follower_.table(), hall.follower_.accepted());
}

// ---- uneven light

TEST(LightFollower, AreasFollowByThemselves) {
  Hall hall;
  hall.look(1, 12);
  EXPECT_THAT(hall.state().areas, Each(testing::DoubleNear(1, 0.07)));
  for (const double gradient : {0.15, 0.3, 0.45, 0.6}) {
    hall.gradient_ = gradient;
    hall.look(1, 15);
  }
  const auto& areas = hall.state().areas;
  EXPECT_LT(*std::min_element(areas.begin(), areas.end()), 0.9);
  EXPECT_GT(*std::max_element(areas.begin(), areas.end()), 1.07);
  EXPECT_EQ(hall.found_.size(), 6u);
}

TEST(LightFollower, LightThatWasUnevenAlreadyIsNoChange) {
  Hall hall;
  hall.gradient_ = 0.4;
  hall.look(1, 40);
  EXPECT_THAT(hall.state().areas, Each(testing::DoubleNear(1, 0.07)));
  expect_gain(hall.state(), 1, 1, 1, 0.05);
}

// ---- bounds and people

TEST(LightFollower, GoesNoFurtherThanItsBounds) {
  Hall hall;
  hall.params_.max_brightness = 1.5;
  hall.look(1, 4);
  hall.look(0.6, 10);
  expect_gain(hall.state(), 1 / 1.5, 1 / 1.5, 1 / 1.5, 0.01);
  EXPECT_EQ(hall.state().following, LightFollowing::kAtBound);
  EXPECT_EQ(hall.state().why, "the brightness differs from the accepted table's by more than a factor 1.5");

  hall.params_.max_brightness = 4;
  hall.params_.max_brightness_per_min = 1.6;
  hall.look(0.6, 10);
  expect_gain(hall.state(), 1 / 1.6, 1 / 1.6, 1 / 1.6, 0.03);
  EXPECT_THAT(hall.state().why, HasSubstr("factor 1.6 in a minute"));
  hall.time_s_ += 61;
  hall.look(0.6, 10);
  expect_gain(hall.state(), 0.6, 0.6, 0.6, 0.05);

  hall.params_.max_balance_per_min = 1.05;
  hall.cast_ = 1.15;
  hall.look(0.6, 20);
  EXPECT_LT(hall.state().gain[0] / 0.6, 1.1);
  EXPECT_THAT(hall.state().why, HasSubstr("colour changes by more than a factor 1.05"));
}

TEST(LightFollower, StandsStillWhileTheGameRunsUnlessChosen) {
  Hall hall;
  hall.look(1, 4);
  hall.game_is_running_ = true;
  hall.look(0.7, 8);
  expect_gain(hall.state(), 1, 1, 1, 0.03);
  EXPECT_EQ(hall.state().why, "the game is running");
  hall.params_.in_match = true;
  hall.look(0.7, 8);
  expect_gain(hall.state(), 0.7, 0.7, 0.7, 0.05);
}

TEST(LightFollower, CanBeRevertedAndSwitchedOff) {
  Hall hall;
  hall.look(1, 4);
  hall.look(0.7, 6);
  EXPECT_NE(hall.follower_.table(), hall.follower_.accepted());
  hall.follower_.take_back();
  EXPECT_EQ(hall.follower_.new_table(), hall.follower_.accepted());
  hall.look(0.7, 6);
  expect_gain(hall.state(), 1, 1, 1, 0);
  EXPECT_THAT(hall.state().why, HasSubstr("returned to the accepted table"));

  hall.params_.enabled = false;
  hall.look(0.7, 1);
  EXPECT_EQ(hall.state().following, LightFollowing::kOff);
  hall.params_.enabled = true;
  hall.look(0.7, 6);
  expect_gain(hall.state(), 1, 1, 1, 0.03);
  EXPECT_EQ(hall.state().following, LightFollowing::kFollowing) << "anew, from the light there is";
}

TEST(LightFollower, SaysThatTheCameraIsNotCalibrated) {
  DrawnScene drawn;
  const ImageView image = drawn.image().view();
  LightFollower follower(drawn.lut_pointer());
  FollowLightParams params;
  params.enabled = true;
  follower.observe(params, {100, image, Scene{}, league_patterns(), {}});
  EXPECT_EQ(follower.state().why, "the camera is not calibrated");
}

}  // namespace
}  // namespace sslv::light_follower_test
