// SPDX-License-Identifier: Apache-2.0
#include "capture/shared_camera.h"

#include "support/becomes.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace sslv {
namespace {

/// Loses an image each time it is asked, and has none.
class LosingSource final : public Source {
 public:
  CaptureStatus next(CapturedImage&, std::string&, std::chrono::milliseconds) override {
    ++dropped_;
    return CaptureStatus::kTimeout;
  }
  std::uint64_t dropped() const noexcept override { return dropped_; }

 private:
  std::uint64_t dropped_ = 0;  // the camera's thread's
};

TEST(SharedCamera, WhatIsLostIsCountedWithoutAnImage) {
  SharedCamera::Taker taker(SharedCamera::get("losing", [] { return std::make_unique<LosingSource>(); }));
  CapturedImage image;
  std::string problem;
  EXPECT_TRUE(test::becomes([&] {
    EXPECT_EQ(taker.next(image, problem, std::chrono::milliseconds(1)), CaptureStatus::kTimeout);
    return taker.dropped() > 0;
  }));
}

}  // namespace
}  // namespace sslv
