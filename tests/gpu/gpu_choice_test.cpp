// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_choice.h"

#include <gtest/gtest.h>

namespace sslv {
namespace {

using namespace std::chrono_literals;

/// A camera whose images take a fixed time on GPU and CPU.
class GpuChoiceTest : public ::testing::Test {
 protected:
  /// Processes one image; returns whether the GPU labelled it.
  bool image() {
    const bool by_gpu = choice_.gpu_is_next(always_);
    choice_.took(by_gpu, by_gpu ? gpu_ : cpu_, now_ += 10ms);
    return by_gpu;
  }
  /// Processes images; returns how many the GPU labelled.
  int images(int count) {
    int by_gpu = 0;
    for (int i = 0; i < count; ++i) by_gpu += image() ? 1 : 0;
    return by_gpu;
  }
  static constexpr int kToMeasure = 2 * static_cast<int>(GpuChoice::kImages + GpuChoice::kWarmUp);

  GpuChoice choice_;
  LabelCost gpu_{1ms, 500us}, cpu_{5ms, 5ms};
  bool always_ = false;
  GpuChoice::TimePoint now_{};
};

TEST_F(GpuChoiceTest, TakesTurnsUntilBothAreMeasured) {
  EXPECT_FALSE(image()) << "the CPU is first: its time is the GPU's deadline";
  EXPECT_TRUE(image());
  EXPECT_EQ(images(kToMeasure - 3), kToMeasure / 2 - 2);
  EXPECT_FALSE(choice_.measured());
  image();
  ASSERT_TRUE(choice_.measured());
  EXPECT_EQ(choice_.measured()->gpu.time, 1ms);
  EXPECT_EQ(choice_.measured()->gpu.cpu_time, 500us);
  EXPECT_EQ(choice_.measured()->cpu.time, 5ms);
  EXPECT_EQ(images(100), 100);
}

TEST_F(GpuChoiceTest, ASlowerGpuIsLeftAloneUnlessItIsAlwaysWanted) {
  gpu_.time = 4900us;  // faster, but by less than a tenth
  images(kToMeasure);
  EXPECT_EQ(images(100), 0);
  always_ = true;
  EXPECT_EQ(images(100), 100);
}

TEST_F(GpuChoiceTest, FirstImagesAndSingleSlowOnesDoNotCount) {
  gpu_.time = 1h;
  images(2 * static_cast<int>(GpuChoice::kWarmUp));
  for (int i = 0; i < 9; ++i) {
    gpu_.time = 1h;
    images(2);
    gpu_.time = 1ms;
    images(2);
  }
  images(4);
  ASSERT_TRUE(choice_.measured());
  EXPECT_EQ(choice_.measured()->gpu.time, 1ms);
}

TEST_F(GpuChoiceTest, MeasuresAgainEveryHour) {
  images(kToMeasure);
  EXPECT_EQ(choice_.number(), 1);
  now_ += GpuChoice::kEvery;
  gpu_.time = 6ms;
  EXPECT_TRUE(image());
  EXPECT_EQ(images(kToMeasure), kToMeasure / 2);
  EXPECT_EQ(choice_.number(), 2);
  EXPECT_EQ(images(10), 0);
  // The last measurement is reported until there is a new one.
  now_ += GpuChoice::kEvery;
  images(2);
  ASSERT_TRUE(choice_.measured());
  EXPECT_EQ(choice_.measured()->gpu.time, 6ms);
}

TEST_F(GpuChoiceTest, AGpuThatBecomesSlowerThanTheCpuWasIsMeasuredAgain) {
  images(kToMeasure);
  gpu_.time = 5ms + 1us;
  EXPECT_EQ(images(GpuChoice::kWatched), static_cast<int>(GpuChoice::kWatched));
  EXPECT_EQ(images(kToMeasure), kToMeasure / 2);
  EXPECT_EQ(choice_.number(), 2);
  EXPECT_EQ(images(10), 0);
}

TEST_F(GpuChoiceTest, AGpuThatIsSlowNowAndThenIsKept) {
  images(kToMeasure);
  for (int i = 0; i < 200; ++i) {
    gpu_.time = i % 2 == 0 ? 1ms : 100ms;
    EXPECT_TRUE(image());
  }
  EXPECT_EQ(choice_.number(), 1);
}

TEST_F(GpuChoiceTest, OneThatIsAlwaysWantedIsNotMeasuredAgainForBeingSlow) {
  always_ = true;
  gpu_.time = 6ms;
  images(kToMeasure);
  EXPECT_EQ(images(300), 300);
  EXPECT_EQ(choice_.number(), 1);
}

TEST_F(GpuChoiceTest, BeginsAgainForOtherImages) {
  images(kToMeasure);
  choice_.begin();
  EXPECT_FALSE(choice_.measured());
  EXPECT_EQ(choice_.cpu_time_so_far(), 0ns);
  images(6);
  EXPECT_EQ(choice_.cpu_time_so_far(), 5ms);
}

}  // namespace
}  // namespace sslv
