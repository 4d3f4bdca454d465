// SPDX-License-Identifier: Apache-2.0
// The stage with a real driver: labels compared with the CPU's, and a GPU that is lost.
#include "faked_reset.h"
#include "gpu/gl.h"
#include "gpu/gpu_threshold_stage.h"
#include "gpu_or_skip.h"
#include "random_images.h"
#include "support/patience.h"
#include "support/segment_check.h"
#include "vision/threshold.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>

#include <gmock/gmock.h>

namespace sslv {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Kind = StageNotes::Kind;

class GpuStageOnGpu : public WithGpu {
 protected:
  GpuStageOnGpu() : stage_(&open_gpu, patient()) {}
  void TearDown() override { faked_reset_status = GL_NO_ERROR; }

  /// Labels an image and compares with the CPU; returns whether the GPU labelled it.
  bool label(const Lut& lut, const Mask& mask, const Image& image) {
    Threshold().process({}, lut, mask, image, plain_);
    std::fill(labels_.labels.begin(), labels_.labels.end(), Label{77});
    stage_.process({.use = GpuThresholdStage::Use::kAlways}, lut, mask, image, labels_, notes_);
    EXPECT_EQ(labels_.labels, plain_.labels);
    EXPECT_EQ(labels_.width, plain_.width);
    EXPECT_EQ(labels_.height, plain_.height);
    EXPECT_EQ(labels_.cell_px, plain_.cell_px);
    return stage_.was_on_gpu();
  }
  template <class Condition>
  static bool becomes(const Condition& condition) {
    const auto until = std::chrono::steady_clock::now() + test::kPatience;
    while (!condition()) {
      if (HasFailure() || std::chrono::steady_clock::now() > until) return false;
      std::this_thread::yield();
    }
    return true;
  }

  StageNotes notes_;

 private:
  static GpuThresholdStage::Limits patient() {
    GpuThresholdStage::Limits limits;
    limits.shortest_deadline = limits.worker.hangs_after = limits.worker.longest_end = 10min;
    limits.worker.shortest_wait = limits.worker.longest_wait = 1ms;
    return limits;
  }

  GpuThresholdStage stage_;
  LabelImage plain_, labels_;
};

TEST_F(GpuStageOnGpu, LabelsAreTheCpusInEveryFormatSizeStrideTableAndMask) {
  Random random(11);
  for (const PixelFormat format : kAllFormats) {
    for (const int width : {2, 30, 32, 34, 322}) {
      const int height = 2 * random_int(random, 1, 40);
      bool is_turned = false;
      for (const Lut& lut : random_luts()) {
        Drawn drawn(format, width, height, random_int(random, 0, 9));
        drawn.fill(random);
        if (is_turned) drawn.turn_over();
        is_turned = !is_turned;
        const Mask mask = random_mask(random, width, height);
        ASSERT_TRUE(becomes([&] { return label(lut, mask, drawn.image()); }))
            << sslv::name_of(format) << ", " << width << " x " << height;
      }
    }
  }
}

TEST_F(GpuStageOnGpu, AResetCostsNoImageAndTheGpuIsOpenedAgain) {
  Random random(12);
  Drawn drawn(PixelFormat::kUyvy, 64, 8);
  drawn.fill(random);
  const auto on_gpu = [&] { return label(random_lut(7), Mask(), drawn.image()); };
  ASSERT_TRUE(becomes(on_gpu));
  for (int times = 0; times < 3; ++times) {
    faked_reset_status = GL_UNKNOWN_CONTEXT_RESET_KHR;
    ASSERT_TRUE(becomes([&] {
      on_gpu();
      return notes_.read().kind == Kind::kWarning;
    }));
    EXPECT_THAT(notes_.read().text,
                HasSubstr("is lost: the GPU was reset; labelling on the CPU, next try in"));
    faked_reset_status = GL_NO_ERROR;
    ASSERT_TRUE(becomes(on_gpu));
    ASSERT_TRUE(becomes([&] {
      on_gpu();
      return notes_.read().text.find(" ms an image") != std::string::npos;
    }));
    EXPECT_EQ(notes_.read().kind, Kind::kNote);
  }
}

TEST_F(GpuStageOnGpu, SeveralCamerasHaveTheirOwn) {
  Random random(13);
  Drawn drawn(PixelFormat::kRgb24, 64, 8);
  drawn.fill(random);
  GpuThresholdStage other;
  StageNotes notes;
  LabelImage labels;
  bool other_was = false;
  ASSERT_TRUE(becomes([&] {
    other.process({.use = GpuThresholdStage::Use::kAlways}, random_lut(8), Mask(), drawn.image(), labels,
                  notes);
    other_was = other_was || other.was_on_gpu();
    return label(random_lut(7), Mask(), drawn.image()) && other_was;
  }));
}

}  // namespace
}  // namespace sslv
