// SPDX-License-Identifier: Apache-2.0
#include "services/colors/follow_light.h"

#include "capture/source.h"
#include "support/becomes.h"
#include "support/drawn_scene.h"

#include <atomic>
#include <chrono>
#include <mutex>
#include <stdexcept>

#include <gmock/gmock.h>

namespace sslv::follow_light_test {
namespace {

/// Camera 7, which sees four robots in a light that a test sets; each request gets a new frame.
class FollowLightTest : public ::testing::Test {
 protected:
  FollowLightTest() {
    params_.enabled = true;
    for (const double light : {1.0, 0.75}) {
      SimulatorOptions options = plain_options();
      options.light = light;
      auto& drawn = drawn_.emplace_back(std::make_unique<DrawnScene>(options));
      for (int i = 0; i < 4; ++i)
        drawn->add_robot(i % 2 == 0 ? Team::kYellow : Team::kBlue, i, 600.0 + 400 * i, 200, i);
      robots_ = drawn->robots().robots;
    }
    accepted_ = drawn_[0]->lut_pointer();
    scene_ = std::make_shared<const Scene>(drawn_[0]->scene());
  }

  FollowLight::Hooks hooks() {
    FollowLight::Hooks hooks;
    hooks.wait_frame = [this](int camera_id, std::uint64_t newer_than,
                              std::chrono::milliseconds) -> std::optional<LentFrame> {
      ++frames_asked_;
      if (gone_) throw CaptureError("no such camera");
      if (camera_id != 7) throw std::logic_error("another camera");
      return LentFrame{newer_than + 1, nullptr, drawn_[dim_ ? 1 : 0]->image().view(),
                       100 + 0.2 * static_cast<double>(newer_than), robots_};
    };
    hooks.cameras = [this] {
      const std::lock_guard lock(mutex_);
      ++looks_;
      return std::vector{
          FollowLight::Camera{7, params_, accepted_, scene_, {std::shared_ptr<void>(), &league_patterns()}}};
    };
    hooks.game_is_running = [this] { return game_is_running_.load(); };
    hooks.put_table = [this](int camera_id, const auto& accepted, std::shared_ptr<const Lut> table) {
      EXPECT_EQ(camera_id, 7);
      const std::lock_guard lock(mutex_);
      EXPECT_EQ(accepted, accepted_);
      in_force_ = std::move(table);
    };
    return hooks;
  }
  std::shared_ptr<const Lut> in_force() {
    const std::lock_guard lock(mutex_);
    return in_force_;
  }
  template <class Condition>
  void wait_until(const char* what, Condition condition) {
    ASSERT_TRUE(test::becomes(condition)) << what;
  }
  /// Waits until this many more rounds have begun.
  void wait_looks(int more) {
    const int wanted = looks_ + more;
    wait_until("looks", [&] { return looks_ >= wanted; });
  }

  std::vector<std::unique_ptr<DrawnScene>> drawn_;
  std::vector<Robot> robots_;
  std::shared_ptr<const Scene> scene_;
  std::atomic<bool> dim_ = false, gone_ = false, game_is_running_ = false;
  std::atomic<int> looks_ = 0, frames_asked_ = 0;
  std::mutex mutex_;  // guards the members below
  FollowLightParams params_;
  std::shared_ptr<const Lut> accepted_, in_force_;
};

constexpr std::chrono::milliseconds kBetweenLooks{1};

TEST_F(FollowLightTest, AppliesAndRevertsTables) {
  FollowLight follow(hooks(), kBetweenLooks);
  wait_until("following", [&] { return follow.status(7).state.following == LightFollowing::kFollowing; });
  EXPECT_EQ(in_force(), nullptr) << "the accepted table needs no other";
  dim_ = true;
  wait_until("a dimmer table", [&] { return follow.status(7).state.gain[1] < 0.77 && in_force(); });
  const auto dimmer = in_force();
  EXPECT_NE(dimmer, accepted_);
  const Rgb pink = paint_color(label::kPink);
  const auto dim = [](int value) { return static_cast<std::uint8_t>(0.45 * value); };
  EXPECT_EQ(dimmer->of_rgb(dim(pink.r), dim(pink.g), dim(pink.b)), label::kPink);
  EXPECT_GE(follow.status(7).steps.size(), 1u);

  follow.take_back(7);
  wait_until("the accepted table", [&] { return in_force() == accepted_; });
  wait_looks(3);
  EXPECT_EQ(in_force(), accepted_);
  EXPECT_EQ(follow.status(7).state.following, LightFollowing::kFrozen);
}

TEST_F(FollowLightTest, SwitchedOffItGivesTheAcceptedTableBackAndLooksAtNothing) {
  FollowLight follow(hooks(), kBetweenLooks);
  wait_until("following", [&] { return follow.status(7).state.following == LightFollowing::kFollowing; });
  dim_ = true;
  wait_until("a dimmer table", [&] { return in_force() != nullptr; });
  {
    const std::lock_guard lock(mutex_);
    params_.enabled = false;
  }
  wait_until("the accepted table", [&] { return in_force() == accepted_; });
  wait_looks(2);
  const int asked = frames_asked_;
  wait_looks(5);
  EXPECT_EQ(frames_asked_, asked);
  EXPECT_EQ(follow.status(7).state.following, LightFollowing::kOff);
}

TEST_F(FollowLightTest, AnotherAcceptedTableRestartsIt) {
  FollowLight follow(hooks(), kBetweenLooks);
  wait_until("following", [&] { return follow.status(7).state.following == LightFollowing::kFollowing; });
  dim_ = true;
  wait_until("a dimmer table", [&] { return follow.status(7).state.gain[1] < 0.77; });
  {
    const std::lock_guard lock(mutex_);
    accepted_ = drawn_[1]->lut_pointer();
    in_force_ = nullptr;
  }
  wait_until("another beginning", [&] {
    const auto state = follow.status(7).state;
    return state.following == LightFollowing::kFollowing && state.gain[1] > 0.95;
  });
  EXPECT_EQ(in_force(), nullptr);
}

TEST_F(FollowLightTest, PausesDuringTheGameAndSurvivesCameraRemoval) {
  game_is_running_ = true;
  FollowLight follow(hooks(), kBetweenLooks);
  wait_until("frozen", [&] { return follow.status(7).state.why == "the game is running"; });
  gone_ = true;
  wait_looks(5);
  gone_ = false;
  game_is_running_ = false;
  wait_until("following", [&] { return follow.status(7).state.following == LightFollowing::kFollowing; });
  EXPECT_EQ(follow.status(8).state.following, LightFollowing::kOff);
}

}  // namespace
}  // namespace sslv::follow_light_test
