// SPDX-License-Identifier: Apache-2.0
#include "capture/files/file_playback.h"

#include "base/error.h"
#include "support/held_thread.h"

#include <thread>

#include <gmock/gmock.h>

namespace sslv::file_playback_test {
namespace {

using std::chrono::milliseconds;

TEST(Playback, GoesOnByItself) {
  Playback playback(10, 0, false);
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 0);
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 1);
  EXPECT_EQ(playback.get("position").value, 1);
  EXPECT_FALSE(playback.begin_again(2));
}

TEST(Playback, BeginsAgainWhenItLoops) {
  Playback playback(10, 0, true);
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 0);
  EXPECT_TRUE(playback.begin_again(1));  // image 0 is shown instead
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 1);
  EXPECT_EQ(playback.get("position").most, 0);
}

TEST(Playback, PausesAndStepsBothWays) {
  Playback playback(10, 0, false);
  playback.set("position", 4);
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 4);
  playback.set("paused", true);
  EXPECT_FALSE(playback.wait_turn(milliseconds(1)));
  playback.set("step", nullptr);
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 5);
  EXPECT_FALSE(playback.wait_turn(milliseconds(0)));
  playback.set("step_back", nullptr);
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 4);
  playback.set("position", 8);  // shown although it is paused
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 8);
  EXPECT_FALSE(playback.wait_turn(milliseconds(0)));
  playback.set("paused", false);
  EXPECT_EQ(playback.wait_turn(milliseconds(0)), 9);
}

TEST(Playback, AWaitEndsWhenAControlIsSet) {
  Playback playback(10, 0.001, false);
  EXPECT_EQ(playback.wait_turn(milliseconds(1000)), 0);  // the next one is due in a quarter of an hour
  std::thread setter([&] { playback.set("position", 7); });
  EXPECT_EQ(playback.wait_turn(std::chrono::hours(1)), 7);
  setter.join();
}

TEST(Playback, AThreadThatIsHeldWhileItSetsAControlDelaysNoPicture) {
  Playback playback(1 << 30, 0, false);
  expect_never_waits([&] { playback.set("position", 7); },
                     [&] { EXPECT_TRUE(playback.wait_turn(milliseconds(0))); });
}

TEST(Playback, RefusesUnknownAndUnavailableControls) {
  Playback playback(10, 0, false);
  EXPECT_THROW(playback.set("position", 10), SettingsError);
  EXPECT_THROW(playback.set("speed", 2.0), SettingsError);  // it has no frame rate
  EXPECT_THROW(playback.set("rewind", true), SettingsError);
  Playback paced(10, 30, false);
  paced.set("speed", 2.0);
  EXPECT_EQ(paced.get("speed").value, 2.0);
}

}  // namespace
}  // namespace sslv::file_playback_test
