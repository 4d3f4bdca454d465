// SPDX-License-Identifier: Apache-2.0
#include "capture/tile.h"

#include "base/error.h"
#include "support/allocation_count.h"

#include <array>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include <gmock/gmock.h>

namespace sslv::tile_test {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

/// A large camera whose results are given by a test.
struct BigCamera {
  static constexpr int kWidth = 64, kHeight = 48;
  std::array<std::uint8_t, 2 * kWidth * kHeight> pixels{};  // the image, then its low bits
  std::mutex mutex;
  std::condition_variable changed;
  std::optional<CaptureStatus> coming;
  std::atomic<int> opened{0}, given_back{0};
  WholePicture whole{};

  BigCamera() {
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i % 251);
  }
  /// Returns once the camera has delivered it.
  void send(CaptureStatus status) {
    std::unique_lock lock(mutex);
    coming = status;
    changed.notify_all();
    changed.wait(lock, [&] { return !coming; });
  }

  class View : public Source {
   public:
    explicit View(BigCamera& camera) : camera_(camera) { ++camera.opened; }
    std::uint64_t dropped() const noexcept override { return counted(7); }
    std::optional<PacketCounts> packets() const noexcept override { return PacketCounts{counted(8), 9}; }
    CaptureStatus next(CapturedImage& image, std::string& problem, milliseconds timeout) override {
      user_ = std::this_thread::get_id();
      std::unique_lock lock(camera_.mutex);
      if (!camera_.changed.wait_for(lock, timeout, [&] { return camera_.coming.has_value(); }))
        return CaptureStatus::kTimeout;
      const CaptureStatus status = *camera_.coming;
      camera_.coming.reset();
      camera_.changed.notify_all();
      if (status == CaptureStatus::kImage) {
        const auto give_back = [](void* owner, void*) noexcept {
          ++static_cast<BigCamera*>(owner)->given_back;
        };
        image.image =
            Image({camera_.pixels.data(), kWidth, kHeight, kWidth, PixelFormat::kMono8, kWidth * kHeight},
                  &camera_, nullptr, give_back);
        image.times.t_capture_s = 7;
        image.whole = camera_.whole;
      } else {
        problem = "so it is";
      }
      return status;
    }

   private:
    /// Counters are not atomic: only the thread that uses the camera may read them.
    std::uint64_t counted(std::uint64_t value) const noexcept {
      return std::this_thread::get_id() == user_.load() ? value : 0;
    }
    BigCamera& camera_;
    std::atomic<std::thread::id> user_;
  };
};

class Tile : public testing::Test {
 protected:
  std::unique_ptr<Source> open(int x, int y, int width, int height) {
    const Json options{{"of", {{"backend", "big"}, {"test", name_}}},
                       {"x", x},
                       {"y", y},
                       {"width", width},
                       {"height", height}};
    return open_tile(options, [this](const Json& of) -> std::unique_ptr<Source> {
      EXPECT_EQ(of.at("backend"), "big");
      return std::make_unique<BigCamera::View>(camera_);
    });
  }
  static CaptureStatus next(Source& source, CapturedImage& image) {
    std::string problem;
    for (;;) {
      const CaptureStatus status = source.next(image, problem, milliseconds(100));
      if (status != CaptureStatus::kTimeout) return status;
    }
  }

  const std::string name_ = testing::UnitTest::GetInstance()->current_test_info()->name();
  BigCamera camera_;
};

TEST_F(Tile, TilesOfOneCameraShareItsBuffer) {
  const auto left = open(0, 0, 32, 48), right = open(32, 10, 32, 20);
  camera_.send(CaptureStatus::kImage);
  EXPECT_EQ(camera_.opened, 1);
  CapturedImage a, b;
  ASSERT_EQ(next(*left, a), CaptureStatus::kImage);
  ASSERT_EQ(next(*right, b), CaptureStatus::kImage);
  EXPECT_EQ(a.image.view().data, camera_.pixels.data());
  EXPECT_EQ(b.image.view().data, camera_.pixels.data() + 10 * BigCamera::kWidth + 32);
  EXPECT_EQ(b.image.view().to_low_bits, BigCamera::kWidth * BigCamera::kHeight)
      << "as far behind as in the whole";
  EXPECT_EQ(b.image.view().width, 32);
  EXPECT_EQ(b.image.view().height, 20);
  EXPECT_EQ(b.image.view().stride_bytes, BigCamera::kWidth);
  EXPECT_EQ(b.times.t_capture_s, 7);
  a = {};
  EXPECT_EQ(camera_.given_back, 0) << "the other tile has it still";
  b = {};
  EXPECT_EQ(camera_.given_back, 1);
}

TEST_F(Tile, ATileKnowsThePictureItIsAPartOf) {
  const auto tile = open(32, 10, 32, 20);
  const auto whole = [&] {
    camera_.send(CaptureStatus::kImage);
    CapturedImage image;
    EXPECT_EQ(next(*tile, image), CaptureStatus::kImage);
    const WholePicture& of = image.whole;
    return std::array{of.width, of.height, of.x, of.y};
  };
  EXPECT_THAT(whole(), testing::ElementsAre(64, 48, 32, 10));
  camera_.whole = {100, 80, 20, 16};  // it reads a part of its sensor
  EXPECT_THAT(whole(), testing::ElementsAre(100, 80, 52, 26));
}

TEST_F(Tile, ASlowTileLosesImagesAndTheOtherNone) {
  const auto slow = open(0, 0, 32, 48), quick = open(32, 0, 32, 48);
  for (int i = 0; i < 5; ++i) {
    camera_.send(CaptureStatus::kImage);
    CapturedImage image;
    ASSERT_EQ(next(*quick, image), CaptureStatus::kImage);
  }
  CapturedImage newest;
  EXPECT_EQ(next(*slow, newest), CaptureStatus::kImage);
  EXPECT_EQ(quick->dropped(), 7U + 0U) << "with those of the camera itself";
  EXPECT_EQ(slow->dropped(), 7U + 4U);
  newest = {};
  EXPECT_EQ(camera_.given_back, 5);
}

TEST_F(Tile, ReportsTheCamerasCounters) {
  const auto tile = open(0, 0, 32, 48);
  camera_.send(CaptureStatus::kImage);
  CapturedImage image;
  ASSERT_EQ(next(*tile, image), CaptureStatus::kImage);
  EXPECT_EQ(tile->dropped(), 7U);
  ASSERT_TRUE(tile->packets());
  EXPECT_EQ(tile->packets()->missing, 8U);
  EXPECT_EQ(tile->packets()->resent, 9U);
}

TEST_F(Tile, ALostCameraIsLostForAllTilesAndReopened) {
  auto left = open(0, 0, 32, 48), right = open(32, 0, 32, 48);
  camera_.send(CaptureStatus::kLost);
  CapturedImage image;
  EXPECT_EQ(next(*left, image), CaptureStatus::kLost);
  EXPECT_EQ(next(*right, image), CaptureStatus::kLost);
  left = open(0, 0, 32, 48);  // while the right one still holds the dead camera
  EXPECT_EQ(camera_.opened, 2);
  right = open(32, 0, 32, 48);
  EXPECT_EQ(camera_.opened, 2);
  camera_.send(CaptureStatus::kImage);
  EXPECT_EQ(next(*left, image), CaptureStatus::kImage);
  EXPECT_EQ(next(*right, image), CaptureStatus::kImage);
}

TEST_F(Tile, DamagedImagesAreReportedToAllTiles) {
  const auto left = open(0, 0, 32, 48), right = open(32, 0, 32, 48);
  camera_.send(CaptureStatus::kIncomplete);
  CapturedImage image;
  EXPECT_EQ(next(*left, image), CaptureStatus::kIncomplete);
  EXPECT_EQ(next(*right, image), CaptureStatus::kIncomplete);
}

TEST_F(Tile, TilesMayReleaseAnImageAtTheSameTime) {
  constexpr int kPictures = 500;
  const auto left = open(0, 0, 32, 48), right = open(32, 0, 32, 48);
  const auto take_all = [](Source& tile) {
    CapturedImage image;
    while (next(tile, image) == CaptureStatus::kImage) image = {};
  };
  std::thread one([&] { take_all(*left); }), other([&] { take_all(*right); });
  for (int i = 0; i < kPictures; ++i) camera_.send(CaptureStatus::kImage);
  camera_.send(CaptureStatus::kEnd);
  one.join();
  other.join();
  EXPECT_EQ(camera_.given_back, kPictures);
}

TEST_F(Tile, PicturesOutliveAllTiles) {
  auto left = open(0, 0, 32, 48);
  camera_.send(CaptureStatus::kImage);
  CapturedImage image;
  ASSERT_EQ(next(*left, image), CaptureStatus::kImage);
  left.reset();
  EXPECT_EQ(image.image.view().data[5], 5);
  image = {};
  EXPECT_EQ(camera_.given_back, 1);
}

TEST_F(Tile, ATileOutsideTheImageIsReported) {
  const auto tile = open(40, 0, 32, 48);
  camera_.send(CaptureStatus::kImage);
  CapturedImage image;
  std::string problem;
  EXPECT_EQ(tile->next(image, problem, milliseconds(10'000)), CaptureStatus::kLost);
  EXPECT_EQ(problem, "the tile of 32 x 48 at (40, 0) is not within the camera's 64 x 48 pixels");
}

TEST_F(Tile, APictureCostsNoAllocation) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  const auto left = open(0, 0, 32, 48), right = open(32, 0, 32, 48);
  const auto round = [&] {
    camera_.send(CaptureStatus::kImage);
    CapturedImage a, b;
    next(*left, a);
    next(*right, b);
  };
  round();
  const std::uint64_t before = allocation_count();
  for (int i = 0; i < 50; ++i) round();
  EXPECT_EQ(allocation_count(), before);
}

std::string refusal(const Json& options) {
  try {
    complete_tile(options, "/source", [](const Json& source, const std::string&) { return source; });
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

TEST(TileOptions, AreChecked) {
  const Json good{{"of", {{"backend", "aravis"}}}, {"x", 2}, {"y", 0}, {"width", 32}, {"height", 48}};
  EXPECT_EQ(refusal(good), "no error");
  Json odd = good;
  odd["x"] = 3;
  EXPECT_EQ(refusal(odd), "/source/x: 3 is not allowed; expected an even number");
  Json tile = good;
  tile["of"]["backend"] = "tile";
  EXPECT_THAT(refusal(tile), HasSubstr("/source/of/backend: \"tile\" is not allowed"));
}

}  // namespace
}  // namespace sslv::tile_test
