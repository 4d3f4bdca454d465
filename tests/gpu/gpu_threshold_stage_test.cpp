// SPDX-License-Identifier: Apache-2.0
#include "gpu/gpu_threshold_stage.h"

#include "fake_gpu.h"
#include "support/allocation_count.h"
#include "support/patience.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

namespace sslv {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Kind = StageNotes::Kind;
using Use = GpuThresholdStage::Use;

/// Limits with which nothing is late or hangs, however slow the machine.
GpuThresholdStage::Limits patient() {
  GpuThresholdStage::Limits limits;
  limits.shortest_deadline = limits.worker.hangs_after = limits.worker.longest_end = 10min;
  limits.worker.shortest_wait = limits.worker.longest_wait = 1ms;
  return limits;
}

std::shared_ptr<const Lut> lut_of(unsigned seed, int bits = 7) {
  std::mt19937 random(seed);
  ColorTable table(bits);
  for (Label& label : table.labels) label = static_cast<Label>(random() % label::kMaxCount);
  return std::make_shared<const Lut>(std::move(table));
}

/// A camera with its own stage; compares all labels with the CPU's.
class GpuThresholdStageTest : public ::testing::Test {
 protected:
  void start(const GpuThresholdStage::Limits& limits) {
    stage_ = std::make_unique<GpuThresholdStage>(open_fake(gpus_), limits);
  }
  void TearDown() override {
    // Releases a thread that the test holds, so that it can end.
    gpus_->is_there = true;
    FakeGpus::set(gpus_->may_open);
    FakeGpus::set(gpus_->may_answer);
    stage_.reset();
    EXPECT_TRUE(becomes([&] { return gpus_->closed >= given_; })) << "a GPU was not closed";
  }

  /// Processes one image, whose memory is freed afterwards; returns whether the GPU labelled it.
  bool image(int width = 40, int height = 6, int more = 0) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>((width + more) * height - more));
    std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<std::uint8_t>(random_()); });
    const Image grey(ImageView{bytes.data(), width, height, width + more, PixelFormat::kMono8}, nullptr,
                     nullptr, nullptr);
    LabelImage wanted;
    Threshold().process({}, *lut_, mask_, grey, wanted);
    std::fill(labels_.labels.begin(), labels_.labels.end(), Label{77});
    stage_->process({.use = use_}, *lut_, mask_, grey, labels_, notes_);
    EXPECT_EQ(labels_.labels, wanted.labels);
    EXPECT_EQ(labels_.width, wanted.width);
    EXPECT_EQ(labels_.height, wanted.height);
    EXPECT_EQ(labels_.cell_px, wanted.cell_px);
    return stage_->was_on_gpu();
  }

  template <class Condition>
  static bool becomes(const Condition& condition) {
    const auto until = std::chrono::steady_clock::now() + test::kPatience;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > until) return false;
      std::this_thread::yield();
    }
    return true;
  }
  bool becomes_on_gpu(int width = 40) {
    return becomes([&] { return image(width); });
  }
  /// Waits until the GPU was asked for an image and did not label it. Call it only when the GPU cannot label
  /// images: otherwise the CPU's turns during a measurement would be mistaken for that.
  bool becomes_missed() {
    // The request may reach it after the stage has stopped waiting.
    const int before = gpus_->asked;
    return becomes([&] { return !image() && gpus_->asked != before; });
  }
  bool note_becomes(Kind kind, const std::string& text) {
    return becomes([&] {
      image();
      const auto note = notes_.read();
      return note.kind == kind && note.text.find(text) != std::string::npos;
    });
  }

  const std::shared_ptr<FakeGpus> gpus_ = std::make_shared<FakeGpus>();
  int given_ = 0;  // GPUs that must be closed at the end
  std::unique_ptr<GpuThresholdStage> stage_;
  std::shared_ptr<const Lut> lut_ = lut_of(1);
  Mask mask_;
  Use use_ = Use::kAlways;
  StageNotes notes_;
  LabelImage labels_;
  std::mt19937 random_{5};
};

TEST_F(GpuThresholdStageTest, TheCpuLabelsUntilTheGpuIsOpen) {
  gpus_->may_open = false;
  start(patient());
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(image());
  EXPECT_EQ(notes_.read().text, "The GPU is being opened: the CPU labels until then.");
  FakeGpus::set(gpus_->may_open);
  EXPECT_TRUE(becomes_on_gpu());
  EXPECT_EQ(gpus_->opened, 1);
  given_ = 1;
}

TEST_F(GpuThresholdStageTest, AGpuThatDoesNotOpenIsTold) {
  gpus_->may_open = false;
  auto limits = patient();
  limits.longest_opening = 1ms;
  start(limits);
  ASSERT_TRUE(
      note_becomes(Kind::kWarning, "GPU (being opened) does not answer: the CPU labels until it does."));
  FakeGpus::set(gpus_->may_open);
  EXPECT_TRUE(note_becomes(Kind::kNote, "the GPU is used"));
}

TEST_F(GpuThresholdStageTest, IsMeasuredAndSaysWhoIsFaster) {
  use_ = Use::kWhenFaster;
  start(patient());
  ASSERT_TRUE(note_becomes(Kind::kNote, "ms an image"));
  const std::string text = notes_.read().text;
  EXPECT_THAT(text, ::testing::MatchesRegex(
                        "GPU \\(Fake 3000\\): [0-9.]+ ms an image \\([0-9.]+ ms of processor time\\); CPU: "
                        "[0-9.]+ ms: the [CG]PU is used\\."));
  EXPECT_EQ(image(), text.find("the GPU is used") != std::string::npos);
}

TEST_F(GpuThresholdStageTest, IsUsedWhereItIsAlwaysWanted) {
  start(patient());
  ASSERT_TRUE(note_becomes(Kind::kNote, "the GPU is used, as configured."));
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(image());
}

TEST_F(GpuThresholdStageTest, IsLeftAloneWhereItIsNeverWanted) {
  use_ = Use::kNever;
  start(patient());
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(image());
  EXPECT_EQ(gpus_->opened, 0);
  EXPECT_EQ(notes_.read().text, "The CPU labels all images, as configured.");
  // The settings may change at runtime.
  use_ = Use::kAlways;
  EXPECT_TRUE(becomes_on_gpu());
  use_ = Use::kNever;
  EXPECT_FALSE(image());
  EXPECT_EQ(notes_.read().text, "The CPU labels all images, as configured.");
}

TEST_F(GpuThresholdStageTest, AProgramOnTheCpuIsNotUsedUnlessItIsWanted) {
  gpus_->is_software = true;
  use_ = Use::kWhenFaster;
  start(patient());
  ASSERT_TRUE(note_becomes(Kind::kNote, "GPU (Fake 3000) is a software renderer: it is not used."));
  EXPECT_FALSE(image());
  use_ = Use::kAlways;
  EXPECT_TRUE(becomes_on_gpu());
}

TEST_F(GpuThresholdStageTest, WithoutAGpuTheCpuLabelsAndItIsLookedForAgain) {
  gpus_->is_there = false;
  use_ = Use::kWhenFaster;
  start(patient());
  ASSERT_TRUE(note_becomes(Kind::kNote, "Labelling on the CPU: no GPU: it is not plugged in; next try in"));
  use_ = Use::kAlways;
  ASSERT_TRUE(
      note_becomes(Kind::kWarning, "Labelling on the CPU: no GPU: it is not plugged in; next try in"));
  gpus_->is_there = true;
  EXPECT_TRUE(becomes_on_gpu());
  EXPECT_GT(gpus_->opened, 1);
}

TEST_F(GpuThresholdStageTest, AGpuThatIsLostCostsNoImageAndIsOpenedAgain) {
  start(patient());
  ASSERT_TRUE(becomes_on_gpu());
  gpus_->fails = gpus_->loses_itself = true;
  ASSERT_TRUE(becomes_missed()) << "the labels of this very image are the CPU's";
  ASSERT_TRUE(note_becomes(Kind::kWarning,
                           "GPU (Fake 3000) is lost: the GPU was reset; labelling on the CPU, next try"));
  gpus_->fails = false;
  EXPECT_TRUE(becomes_on_gpu());
  EXPECT_GT(gpus_->opened, 1);
  EXPECT_TRUE(note_becomes(Kind::kNote, "the GPU is used"));
  given_ = 2;
}

TEST_F(GpuThresholdStageTest, ALostGpuThatDoesNotComeBackStaysAWarning) {
  use_ = Use::kWhenFaster;
  start(patient());
  ASSERT_TRUE(note_becomes(Kind::kNote, "ms an image"));
  gpus_->is_there = false;
  gpus_->fails = gpus_->loses_itself = true;
  use_ = Use::kAlways;
  ASSERT_TRUE(becomes_missed());
  use_ = Use::kWhenFaster;
  EXPECT_TRUE(note_becomes(
      Kind::kWarning,
      "GPU (Fake 3000) is lost: no GPU: it is not plugged in; labelling on the CPU, next try in"));
}

TEST_F(GpuThresholdStageTest, OneThatGivesNoLabelsIsOpenedAgainToo) {
  start(patient());
  ASSERT_TRUE(becomes_on_gpu());
  gpus_->fails = true;  // without being lost, as when memory runs out
  ASSERT_TRUE(becomes_missed());
  gpus_->fails = false;
  EXPECT_TRUE(becomes_on_gpu());
  EXPECT_GT(gpus_->opened, 1);
}

TEST_F(GpuThresholdStageTest, AGpuThatHangsCostsOneDeadlineAndIsOpenedAgainWhenItComesBack) {
  auto limits = patient();
  limits.shortest_deadline = 1ms;
  limits.worker.hangs_after = 1ms;
  start(limits);
  ASSERT_TRUE(becomes_on_gpu());
  gpus_->may_answer = false;
  ASSERT_TRUE(becomes_missed());
  const int asked = gpus_->asked, opened = gpus_->opened;
  ASSERT_TRUE(note_becomes(Kind::kWarning, "GPU (Fake 3000) does not answer: the CPU labels until it does."));
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(image());
  EXPECT_EQ(gpus_->asked, asked) << "nobody waits for it again";
  FakeGpus::set(gpus_->may_answer);
  EXPECT_TRUE(becomes_on_gpu());
  EXPECT_GT(gpus_->opened, opened);
}

TEST_F(GpuThresholdStageTest, AGpuThatIsOnlyLateStaysOpen) {
  auto limits = patient();
  limits.shortest_deadline = 1ms;
  start(limits);
  ASSERT_TRUE(becomes_on_gpu());
  for (int times = 0; times < 5; ++times) {
    gpus_->may_answer = false;
    ASSERT_TRUE(becomes_missed());
    FakeGpus::set(gpus_->may_answer);
    ASSERT_TRUE(becomes_on_gpu());
  }
  EXPECT_EQ(gpus_->opened, 1);
}

TEST_F(GpuThresholdStageTest, EndsWhileTheGpuHangs) {
  auto limits = patient();
  limits.shortest_deadline = limits.worker.longest_end = 1ms;
  start(limits);
  ASSERT_TRUE(becomes_on_gpu());
  gpus_->may_answer = false;
  ASSERT_TRUE(becomes_missed());
  stage_.reset();
  lut_.reset();  // the hanging thread has its own copy of its data
  EXPECT_EQ(gpus_->closed, 0);
  given_ = 1;
}

TEST_F(GpuThresholdStageTest, EndsWhileTheGpuIsBeingOpened) {
  gpus_->may_open = false;
  auto limits = patient();
  limits.worker.longest_end = 1ms;
  start(limits);
  ASSERT_TRUE(becomes([&] {
    image();
    return gpus_->opened == 1;
  }));
  stage_.reset();
  given_ = 1;
}

TEST_F(GpuThresholdStageTest, OtherSizesStridesTablesAndMasksAreMetWithTheSameLabels) {
  start(patient());
  MaskSettings settings;
  settings.exclude = {{{{3, 1}, {20, 1}, {20, 4}, {3, 4}}}};
  mask_ = Mask(settings);
  for (const int bits : {7, 8}) {
    lut_ = lut_of(static_cast<unsigned>(bits), bits);
    for (const int width : {1, 15, 16, 17, 33, 64}) {
      ASSERT_TRUE(becomes_on_gpu(width)) << width;
      for (const int more : {0, 1, 15}) {
        EXPECT_TRUE(becomes([&] { return image(width, 6, more); }));
      }
    }
    lut_ = lut_of(static_cast<unsigned>(bits) + 10, bits);
    EXPECT_TRUE(becomes_on_gpu(64));
  }
  EXPECT_EQ(gpus_->opened, 1);
}

TEST_F(GpuThresholdStageTest, AnotherSizeIsMeasuredAgain) {
  start(patient());
  ASSERT_TRUE(note_becomes(Kind::kNote, "ms an image"));
  ASSERT_TRUE(becomes([&] {
    image(64);
    return notes_.read().text == "GPU (Fake 3000): it is being measured.";
  }));
  ASSERT_TRUE(becomes([&] {
    image(64);
    return notes_.read().text.find("ms an image") != std::string::npos;
  }));
}

TEST_F(GpuThresholdStageTest, ImagesThatTheGpuDoesNotTakeAreTheCpus) {
  gpus_->widest = 50;
  start(patient());
  ASSERT_TRUE(becomes([&] {
    EXPECT_FALSE(image(64));
    return notes_.read().text == "GPU (Fake 3000) is not used: the image is too large for this GPU.";
  }));
  EXPECT_EQ(notes_.read().kind, Kind::kWarning) << "it is always wanted";
  EXPECT_TRUE(becomes_on_gpu(50));
  EXPECT_EQ(gpus_->opened, 1);
}

TEST_F(GpuThresholdStageTest, AnImageWithoutPixelsIsTheCpus) {
  start(patient());
  ASSERT_TRUE(becomes_on_gpu());
  const Image nothing(ImageView{nullptr, 0, 0, 0, PixelFormat::kMono8}, nullptr, nullptr, nullptr);
  stage_->process({.use = use_}, *lut_, mask_, nothing, labels_, notes_);
  EXPECT_FALSE(stage_->was_on_gpu());
  EXPECT_TRUE(labels_.labels.empty());
}

TEST_F(GpuThresholdStageTest, AllocatesNothingForAnImage) {
  if (!counts_allocations()) GTEST_SKIP() << "a sanitizer has an allocator of its own";
  start(patient());
  const std::vector<std::uint8_t> bytes(std::size_t{64} * 48, 90);
  const Image grey(ImageView{bytes.data(), 64, 48, 64, PixelFormat::kMono8}, nullptr, nullptr, nullptr);
  const auto label = [&](int images) {
    int by_gpu = 0;
    for (int i = 0; i < images; ++i) {
      stage_->process({.use = use_}, *lut_, mask_, grey, labels_, notes_);
      by_gpu += stage_->was_on_gpu() ? 1 : 0;
    }
    return by_gpu;
  };
  ASSERT_TRUE(becomes([&] { return label(1) == 1; }));
  const std::uint64_t before = allocation_count();
  // If it is slower on a busy machine, it is measured again after at least 108 images, of which the CPU then
  // labels 22.
  EXPECT_GT(label(500), 380) << "measured, and then used";
  EXPECT_EQ(allocation_count() - before, 0U);
}

}  // namespace
}  // namespace sslv
