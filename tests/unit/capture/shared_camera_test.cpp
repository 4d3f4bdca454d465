// SPDX-License-Identifier: Apache-2.0
#include "capture/shared_camera.h"

#include "support/becomes.h"
#include "support/patience.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <latch>
#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace sslv::shared_camera_test {
namespace {

/// Drops an image on each call and delivers none.
class LosingSource final : public Source {
 public:
  CaptureStatus next(CapturedImage&, std::string&, std::chrono::milliseconds) override {
    ++dropped_;
    return CaptureStatus::kTimeout;
  }
  std::uint64_t dropped() const noexcept override { return dropped_; }

 private:
  std::uint64_t dropped_ = 0;  // only for the camera's thread
};

TEST(SharedCamera, CountsLossesWithoutAnImage) {
  SharedCamera::Taker taker(SharedCamera::get("losing", [] { return std::make_unique<LosingSource>(); }));
  CapturedImage image;
  std::string problem;
  EXPECT_TRUE(test::becomes([&] {
    EXPECT_EQ(taker.next(image, problem, std::chrono::milliseconds(1)), CaptureStatus::kTimeout);
    return taker.dropped() > 0;
  }));
}

TEST(SharedCamera, AnOpeningThatTakesLongDelaysThatCameraOnly) {
  std::latch is_opening(1), may_open(1);
  std::atomic<int> slow_openings{0};
  const auto get_slow = [&] {
    return SharedCamera::get("slow", [&] {
      if (++slow_openings == 1) is_opening.count_down();
      may_open.wait();
      return std::make_unique<LosingSource>();
    });
  };
  auto first = std::async(std::launch::async, get_slow);
  is_opening.wait();
  auto second = std::async(std::launch::async, get_slow);
  auto other = std::async(std::launch::async, [] {
    return SharedCamera::get("quick", [] { return std::make_unique<LosingSource>(); });
  });
  EXPECT_EQ(other.wait_for(test::kPatience), std::future_status::ready);
  may_open.count_down();
  EXPECT_EQ(first.get(), second.get());
  EXPECT_EQ(slow_openings, 1);
}

}  // namespace
}  // namespace sslv::shared_camera_test
