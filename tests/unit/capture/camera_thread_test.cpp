// SPDX-License-Identifier: Apache-2.0
#include "capture/camera_thread.h"

#include "base/clock.h"
#include "support/allocation_count.h"
#include "support/becomes.h"
#include "support/held_thread.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <latch>
#include <mutex>
#include <optional>
#include <thread>

#include <gmock/gmock.h>

namespace sslv::camera_thread_test {
namespace {

using std::chrono::milliseconds;

constexpr CameraDelays kAtOnce{milliseconds(0), milliseconds(0), test::kPatience};
/// stop() abandons the camera almost at once.
constexpr CameraDelays kLeftBehind{milliseconds(0), milliseconds(0), milliseconds(1)};

/// A fake camera that plays steps given by a test. Outlives the threads that use it.
class FakeCamera {
 public:
  struct Step {
    CaptureStatus status = CaptureStatus::kImage;
    std::string problem{};
    bool throws = false;
    void (*spoil)(CapturedImage& image) = nullptr;
  };

  void play(const std::vector<Step>& steps) {
    const std::lock_guard lock(mutex_);
    steps_.insert(steps_.end(), steps.begin(), steps.end());
    changed_.notify_all();
  }
  /// The next `count` attempts to open it fail.
  void refuse(int count) {
    const std::lock_guard lock(mutex_);
    refusals_ = count;
  }
  /// Closing blocks until release().
  void block_closing() { block(blocks_closing_, true); }
  /// Opening blocks until release().
  void block_opening() { block(blocks_opening_, true); }
  void release() {
    block(blocks_closing_, false);
    block(blocks_opening_, false);
  }

  /// After the queued steps, each call of next() plays this step at once.
  void play_forever(const Step& step) {
    const std::lock_guard lock(mutex_);
    forever_ = step;
    changed_.notify_all();
  }

  int wait_for_opened(int at_least) { return wait_for(opened_, at_least); }
  int wait_for_closed(int at_least) { return wait_for(closed_, at_least); }
  int wait_for_attempts(int at_least) { return wait_for(attempts_, at_least); }
  int attempts() const {
    const std::lock_guard lock(mutex_);
    return attempts_;
  }
  int closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
  }

  std::unique_ptr<Source> open() {
    std::unique_lock lock(mutex_);
    ++attempts_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return !blocks_opening_; });
    if (refusals_ > 0) {
      --refusals_;
      throw CaptureError("camera \"left\": not found");
    }
    ++opened_;
    changed_.notify_all();
    return std::make_unique<Opened>(*this);
  }

 private:
  class Opened final : public Source {
   public:
    explicit Opened(FakeCamera& camera) : camera_(camera) {}
    ~Opened() override {
      std::unique_lock lock(camera_.mutex_);
      camera_.changed_.wait(lock, [&] { return !camera_.blocks_closing_; });
      ++camera_.closed_;
      camera_.changed_.notify_all();
    }
    CaptureStatus next(CapturedImage& image, std::string& problem, milliseconds timeout) override {
      std::unique_lock lock(camera_.mutex_);
      if (!camera_.changed_.wait_for(lock, timeout,
                                     [&] { return !camera_.steps_.empty() || camera_.forever_; })) {
        return CaptureStatus::kTimeout;
      }
      Step step;
      if (camera_.steps_.empty()) {
        step = *camera_.forever_;
      } else {
        step = camera_.steps_.front();
        camera_.steps_.pop_front();
      }
      if (step.throws) throw std::logic_error(step.problem);
      problem = step.problem;
      if (step.status == CaptureStatus::kImage) {
        ++images_;
        image.image = Image({kPixels, 4, 2, 8, PixelFormat::kUyvy}, nullptr, nullptr, nullptr);
        image.times.t_capture_s = unix_time_s();
        if (step.spoil != nullptr) step.spoil(image);
      }
      return step.status;
    }
    /// As if the driver had dropped one image for each delivered one.
    std::uint64_t dropped() const noexcept override { return images_; }

   private:
    std::uint64_t images_ = 0;
    static constexpr std::uint8_t kPixels[16]{};
    FakeCamera& camera_;
  };

  void block(bool& what, bool value) {
    const std::lock_guard lock(mutex_);
    what = value;
    changed_.notify_all();
  }
  int wait_for(const int& counter, int at_least) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, test::kPatience, [&] { return counter >= at_least; });
    return counter;
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Step> steps_;
  std::optional<Step> forever_;
  int refusals_ = 0, attempts_ = 0, opened_ = 0, closed_ = 0;
  bool blocks_closing_ = false, blocks_opening_ = false;
};

const FakeCamera::Step kImage{CaptureStatus::kImage};
const FakeCamera::Step kEnd{CaptureStatus::kEnd};
FakeCamera::Step lost(const std::string& why) {
  return {CaptureStatus::kLost, why};
}
FakeCamera::Step damaged(const std::string& why) {
  return {CaptureStatus::kIncomplete, why};
}
FakeCamera::Step throwing(const std::string& why) {
  return {CaptureStatus::kImage, why, true};
}

/// Waits until the thread's health is `wanted` and returns it; after a timeout, returns the last one.
CameraHealth wait_for(const CameraThread& thread, const std::function<bool(const CameraHealth&)>& wanted) {
  CameraHealth health;
  test::becomes([&] {
    health = thread.health();
    return wanted(health);
  });
  return health;
}
auto frames(std::uint64_t count) {
  return [count](const CameraHealth& health) { return health.frames == count; };
}
bool some_frames(const CameraHealth& health) {
  return health.frames > 0;
}
auto state(CameraState wanted) {
  return [wanted](const CameraHealth& health) { return health.state == wanted; };
}

class CameraThreadTest : public testing::Test {
 protected:
  std::unique_ptr<CameraThread> make(CameraDelays delays = kAtOnce, ThreadSettings settings = {}) {
    return std::make_unique<CameraThread>(
        "camera 0", settings, [camera = camera_] { return camera->open(); },
        [this](CapturedImage&& image) {
          ++taken_;
          if (hook_) hook_(image);
        },
        delays, totals_,
        [this] {
          ++idle_calls_;
          return buffers_are_out_.load();
        });
  }
  std::unique_ptr<CameraThread> start(CameraDelays delays = kAtOnce, ThreadSettings settings = {}) {
    auto thread = make(delays, settings);
    thread->start();
    return thread;
  }

  std::shared_ptr<CaptureTotals> totals_ = std::make_shared<CaptureTotals>();
  std::shared_ptr<FakeCamera> camera_ = std::make_shared<FakeCamera>();
  std::atomic<int> taken_{0}, idle_calls_{0};
  std::atomic<bool> buffers_are_out_{false};
  std::function<void(const CapturedImage&)> hook_;
};

TEST_F(CameraThreadTest, HandsPicturesOver) {
  const auto thread = start();
  camera_->play({kImage, kImage, kImage});
  const CameraHealth health = wait_for(*thread, frames(3));
  EXPECT_EQ(health.frames, 3U);
  EXPECT_EQ(taken_, 3);
  EXPECT_EQ(health.state, CameraState::kRunning);
  EXPECT_EQ(health.error, "");
  EXPECT_EQ(health.width, 4);
  EXPECT_EQ(health.height, 2);
  EXPECT_EQ(health.format, PixelFormat::kUyvy);
  EXPECT_GT(health.progress_ns, 0);
}

TEST_F(CameraThreadTest, CountsDamagedPicturesAndGoesOn) {
  const auto thread = start();
  camera_->play({damaged("3 packets are missing"), damaged("3 packets are missing"), kImage});
  const CameraHealth health = wait_for(*thread, frames(1));
  EXPECT_EQ(health.incomplete, 2U);
  EXPECT_EQ(health.reconnects, 0U);
  EXPECT_EQ(taken_, 1);
}

TEST_F(CameraThreadTest, CountsDroppedPicturesAcrossAReconnection) {
  const auto thread = start();
  camera_->play({kImage, kImage, lost("no heartbeat"), kImage});
  EXPECT_EQ(wait_for(*thread, frames(3)).dropped, 3U);
}

TEST_F(CameraThreadTest, ItsTotalsGoOnWithTheNextThread) {
  for (std::uint64_t i = 1; i <= 2; ++i) {
    const auto thread = start();
    camera_->play({damaged("3 packets are missing"), kImage, lost("no heartbeat"), kImage});
    const CameraHealth health = wait_for(*thread, frames(2));
    EXPECT_EQ(health.incomplete, 1U);
    EXPECT_EQ(health.reconnects, 1U);
    EXPECT_GT(health.dropped, 0U);
    EXPECT_EQ(totals_->incomplete, i * health.incomplete);
    EXPECT_EQ(totals_->reconnects, i * health.reconnects);
    EXPECT_EQ(totals_->dropped, i * health.dropped);
  }
}

TEST_F(CameraThreadTest, ReopensALostCamera) {
  const auto thread = start();
  camera_->play({kImage, lost("no heartbeat"), kImage});
  const CameraHealth health = wait_for(*thread, frames(2));
  EXPECT_EQ(health.frames, 2U);
  EXPECT_EQ(health.state, CameraState::kRunning);
  EXPECT_EQ(health.error, "") << "what is over is not shown";
  EXPECT_EQ(health.reconnects, 1U);
  EXPECT_EQ(camera_->wait_for_closed(1), 1) << "the lost one";
}

TEST_F(CameraThreadTest, SaysWhyACameraIsLost) {
  camera_->refuse(1 << 30);
  const auto thread = start({milliseconds(1), milliseconds(1)});
  const CameraHealth health = wait_for(*thread, state(CameraState::kLost));
  EXPECT_EQ(health.state, CameraState::kLost);
  EXPECT_EQ(health.error, "camera \"left\": not found");
  EXPECT_EQ(health.frames, 0U);
}

TEST_F(CameraThreadTest, TriesUntilItCanBeOpened) {
  camera_->refuse(5);
  camera_->play({kImage});
  const auto thread = start();
  const CameraHealth health = wait_for(*thread, frames(1));
  EXPECT_EQ(health.state, CameraState::kRunning);
  EXPECT_EQ(health.reconnects, 0U) << "it had never been open";
  EXPECT_EQ(camera_->wait_for_attempts(6), 6);
}

TEST_F(CameraThreadTest, ALostCameraIsTriedAgainWhenAsked) {
  camera_->refuse(2);
  camera_->play({kImage});
  const auto thread = start({std::chrono::hours(1), std::chrono::hours(1)});
  wait_for(*thread, state(CameraState::kLost));
  EXPECT_EQ(thread->try_now(), CameraState::kLost);
  EXPECT_EQ(camera_->wait_for_attempts(2), 2) << "it was refused again";
  EXPECT_TRUE(test::becomes([&] { return thread->try_now() == CameraState::kRunning; }));
  EXPECT_EQ(wait_for(*thread, frames(1)).state, CameraState::kRunning);
}

TEST_F(CameraThreadTest, RetryingDoesNotAffectARunningOrEndedCamera) {
  camera_->play({kImage});
  const auto thread = start();
  wait_for(*thread, frames(1));
  EXPECT_EQ(thread->try_now(), CameraState::kRunning);
  camera_->play({kImage, kEnd});
  EXPECT_EQ(wait_for(*thread, state(CameraState::kEnded)).frames, 2U);
  EXPECT_EQ(thread->try_now(), CameraState::kEnded);
  thread->stop();
  EXPECT_EQ(camera_->wait_for_attempts(1), 1) << "it was not opened again";
}

TEST_F(CameraThreadTest, TreatsASourceThatThrowsAsLost) {
  camera_->play({throwing("a defect"), kImage});
  const auto thread = start();
  const CameraHealth health = wait_for(*thread, frames(1));
  EXPECT_EQ(health.frames, 1U);
  EXPECT_EQ(health.reconnects, 1U);
}

TEST_F(CameraThreadTest, ARecordingEnds) {
  camera_->play({kImage, kEnd, kImage});
  const auto thread = start();
  const CameraHealth health = wait_for(*thread, state(CameraState::kEnded));
  EXPECT_EQ(health.state, CameraState::kEnded);
  EXPECT_EQ(health.frames, 1U);
  EXPECT_EQ(camera_->wait_for_closed(1), 1);
  thread->stop();
  EXPECT_EQ(camera_->wait_for_attempts(1), 1) << "not opened again";
}

TEST_F(CameraThreadTest, ReopensWhileTheDeadOneIsStillClosing) {
  camera_->block_closing();
  const auto thread = start();
  camera_->play({lost("dead"), lost("dead"), kImage});
  EXPECT_EQ(wait_for(*thread, frames(1)).reconnects, 2U);
  EXPECT_EQ(camera_->closed(), 0);
  camera_->release();
  EXPECT_EQ(camera_->wait_for_closed(2), 2);
}

/// However fast the camera fails, the pauses between attempts grow: 1 + 2 + 4 + ... ms before the last one.
void expect_growing_waits(FakeCamera& camera, std::chrono::steady_clock::time_point start) {
  constexpr int kAttempts = 9;
  EXPECT_GE(camera.wait_for_attempts(kAttempts), kAttempts);
  EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds((1 << (kAttempts - 1)) - 1));
}
constexpr CameraDelays kGrowing{milliseconds(1), std::chrono::hours(1)};

TEST_F(CameraThreadTest, WaitsLongerAndLongerForASourceThatThrowsAtOnce) {
  camera_->play_forever(throwing("a defect"));
  const auto begin = std::chrono::steady_clock::now();
  const auto thread = start(kGrowing);
  expect_growing_waits(*camera_, begin);
}

TEST_F(CameraThreadTest, WaitsLongerAndLongerForACameraThatIsLostAtOnce) {
  camera_->play_forever(lost("no heartbeat"));
  const auto begin = std::chrono::steady_clock::now();
  const auto thread = start(kGrowing);
  expect_growing_waits(*camera_, begin);
}

TEST_F(CameraThreadTest, WaitsLongerAndLongerForACameraThatIsLostAfterDamagedPictures) {
  for (int i = 0; i < 20; ++i) camera_->play({damaged("packets are missing"), lost("no heartbeat")});
  const auto begin = std::chrono::steady_clock::now();
  const auto thread = start(kGrowing);
  expect_growing_waits(*camera_, begin);
}

TEST_F(CameraThreadTest, APictureMakesTheNextWaitShortAgain) {
  camera_->refuse(6);
  camera_->play({kImage, lost("no heartbeat"), kImage});
  const auto thread = start({milliseconds(1), std::chrono::hours(1)});
  EXPECT_EQ(wait_for(*thread, frames(2)).frames, 2U);
}

TEST_F(CameraThreadTest, LogsFewLinesDuringManyLosses) {
  constexpr int kLosses = 500;
  const double begin_s = steady_s();
  testing::internal::CaptureStderr();
  {
    const auto thread = start();
    std::vector<FakeCamera::Step> steps;
    for (int i = 0; i < kLosses; ++i) {
      steps.insert(steps.end(),
                   {damaged("packets are missing"), damaged("packets are missing"), lost("no heartbeat")});
    }
    camera_->play(steps);
    EXPECT_EQ(
        wait_for(*thread, [](const CameraHealth& health) { return health.reconnects >= kLosses; }).incomplete,
        2U * kLosses);
  }
  const std::string log = testing::internal::GetCapturedStderr();
  // Damaged images are logged once a second, and delivering all of them may take several seconds.
  EXPECT_LT(static_cast<double>(std::count(log.begin(), log.end(), '\n')), 20 + steady_s() - begin_s) << log;
}

TEST_F(CameraThreadTest, PausesBetweenImmediateFailures) {
  constexpr std::uint64_t kDamaged = 60;
  const auto begin = std::chrono::steady_clock::now();
  camera_->play_forever(damaged("packets are missing"));
  const auto thread = start();
  wait_for(*thread, [](const CameraHealth& health) { return health.incomplete >= kDamaged; });
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(kDamaged - 20));
}

/// Gives the view of the 4x2 UYVY image a value that no driver should deliver.
template <class T, T ImageView::*member, int value>
void set_view(CapturedImage& image) {
  ImageView view = image.image.view();
  view.*member = static_cast<T>(value);
  image.image.narrow_to(view);
}

TEST_F(CameraThreadTest, InvalidImagesAreDropped) {
  const auto spoilt = [](void (*spoil)(CapturedImage&)) { return FakeCamera::Step{.spoil = spoil}; };
  const std::vector<FakeCamera::Step> garbage{
      spoilt([](CapturedImage& image) { image.image = Image(); }),
      spoilt([](CapturedImage& image) {
        image.image.narrow_to({nullptr, 4, 2, 8, PixelFormat::kUyvy});
      }),
      spoilt(&set_view<int, &ImageView::width, 0>),
      spoilt(&set_view<int, &ImageView::width, -4>),
      spoilt(&set_view<int, &ImageView::width, 3>),
      spoilt(&set_view<int, &ImageView::height, 0>),
      spoilt(&set_view<int, &ImageView::height, 1 << 20>),
      spoilt(&set_view<std::ptrdiff_t, &ImageView::stride_bytes, 7>),
      spoilt(&set_view<std::ptrdiff_t, &ImageView::stride_bytes, 0>),
      spoilt(&set_view<std::ptrdiff_t, &ImageView::stride_bytes, -8>),
      spoilt(&set_view<PixelFormat, &ImageView::format, 200>),
  };
  const auto thread = start();
  camera_->play(garbage);
  camera_->play({kImage});
  const CameraHealth health = wait_for(*thread, frames(1));
  EXPECT_EQ(health.frames, 1U);
  EXPECT_EQ(health.incomplete, garbage.size());
  EXPECT_EQ(health.state, CameraState::kRunning) << "it goes on with the next good one";
  EXPECT_EQ(camera_->wait_for_opened(1), 1);
}

TEST_F(CameraThreadTest, ATimeThatCannotBeIsReplaced) {
  std::vector<CaptureTimes> seen;
  hook_ = [&](const CapturedImage& image) { seen.push_back(image.times); };
  const auto spoilt = [](void (*spoil)(CapturedImage&)) { return FakeCamera::Step{.spoil = spoil}; };
  const double begin_s = unix_time_s();
  const auto thread = start();
  camera_->play({
      spoilt([](CapturedImage& image) { image.times.t_capture_s = std::nan(""); }),
      spoilt([](CapturedImage& image) { image.times.t_capture_s = 1e300; }),
      spoilt([](CapturedImage& image) { image.times.t_capture_s = -INFINITY; }),
      spoilt([](CapturedImage& image) {
        image.times = {0, 7.0, 1e-6, true, 0};
      }),
      spoilt([](CapturedImage& image) { image.times.t_capture_s += 3600; }),
      spoilt([](CapturedImage& image) { image.times.t_capture_s -= 3600; }),
      spoilt([](CapturedImage& image) {
        image.times = {unix_time_s() - 0.5, std::nan(""), std::nan(""), false, 0};
      }),
      spoilt([](CapturedImage& image) {
        image.times = {unix_time_s() - 0.5, 7.0, 1e-3, true, 0};
      }),
  });
  wait_for(*thread, frames(8));
  thread->stop();
  ASSERT_EQ(seen.size(), 8u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_TRUE(seen[i].t_capture_s >= begin_s && seen[i].t_capture_s <= unix_time_s()) << i;
    EXPECT_FALSE(seen[i].t_capture_sigma_s) << i;
    EXPECT_FALSE(seen[i].is_by_ptp) << i;
  }
  EXPECT_EQ(seen[3].t_capture_camera_s, 7.0);
  EXPECT_FALSE(seen[6].t_capture_camera_s);
  EXPECT_FALSE(seen[6].t_capture_sigma_s);
  EXPECT_EQ(seen[7].t_capture_sigma_s, 1e-3) << "a good one is left alone";
  EXPECT_TRUE(seen[7].is_by_ptp);
}

TEST_F(CameraThreadTest, RetriesAfterAnyFailureToOpen) {
  std::atomic<int> attempts{0};
  CameraThread thread(
      "camera 0", {},
      [&]() -> std::unique_ptr<Source> {
        switch (attempts++) {
          case 0: return nullptr;
          case 1: throw 7;
          default: return camera_->open();
        }
      },
      [](CapturedImage&&) {}, kAtOnce);
  thread.start();
  camera_->play({kImage});
  EXPECT_EQ(wait_for(thread, frames(1)).frames, 1U);
  EXPECT_EQ(attempts, 3);
}

TEST_F(CameraThreadTest, StopsDuringAStorm) {
  for (const FakeCamera::Step& step :
       {damaged("packets are missing"), lost("no heartbeat"), throwing("a defect")}) {
    camera_->play_forever(step);
    const int attempts = camera_->attempts();
    const auto thread = start();
    wait_for(*thread, [&](const CameraHealth& health) {
      return health.incomplete > 20 || camera_->attempts() > attempts + 20;
    });
    thread->stop();
    EXPECT_EQ(camera_->closed(), camera_->wait_for_opened(0));
  }
}

TEST_F(CameraThreadTest, StopClosesTheCamera) {
  const auto thread = start();
  camera_->play({kImage});
  wait_for(*thread, frames(1));
  thread->stop();
  EXPECT_EQ(camera_->closed(), 1);
  thread->stop();  // again: no effect
}

TEST_F(CameraThreadTest, StopInterruptsTheWaitBeforeTheNextAttempt) {
  camera_->refuse(1 << 30);
  const auto thread = start({std::chrono::hours(1), std::chrono::hours(1), test::kPatience});
  wait_for(*thread, state(CameraState::kLost));
  testing::internal::CaptureStderr();
  thread->stop();
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::Not(testing::HasSubstr("does not answer")));
}

TEST_F(CameraThreadTest, StopLeavesACameraBehindThatDoesNotClose) {
  camera_->block_closing();
  const auto thread = start(kLeftBehind);
  camera_->wait_for_opened(1);
  thread->stop();
  EXPECT_EQ(camera_->closed(), 0);
  camera_->release();
  EXPECT_EQ(camera_->wait_for_closed(1), 1);
}

TEST_F(CameraThreadTest, StopLeavesACameraBehindThatDoesNotOpen) {
  camera_->block_opening();
  camera_->play({kImage});
  const auto thread = start(kLeftBehind);
  camera_->wait_for_attempts(1);
  thread->stop();
  camera_->release();
  EXPECT_EQ(camera_->wait_for_closed(1), 1);
  EXPECT_EQ(taken_, 0) << "nothing is handed over after stop()";
}

TEST_F(CameraThreadTest, CamerasThatDoNotOpenAreWaitedForTogether) {
  // With this many cameras, waiting for one after the other would exceed kPatience.
  constexpr CameraDelays kDelays{.stop = milliseconds(2000)};
  constexpr int kCameras = test::kPatience / kDelays.stop + 1;
  camera_->block_opening();
  std::vector<std::unique_ptr<CameraThread>> threads;
  for (int i = 0; i < kCameras; ++i) threads.push_back(start(kDelays));
  camera_->wait_for_attempts(kCameras);
  const auto begin = std::chrono::steady_clock::now();
  for (const auto& thread : threads) thread->ask_to_stop();
  for (const auto& thread : threads) thread->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, test::kPatience) << "as long as one after the other";
  camera_->release();
  EXPECT_EQ(camera_->wait_for_closed(kCameras), kCameras);
}

TEST_F(CameraThreadTest, StopWaitsForAPictureBeingProcessed) {
  std::latch entered(1), go_on(1);
  std::atomic<bool> left{false};
  hook_ = [&](const CapturedImage&) {
    entered.count_down();
    go_on.wait();
    left = true;
  };
  const auto thread = start();
  camera_->play({kImage});
  entered.wait();
  std::thread stopper([&] {
    thread->stop();
    EXPECT_TRUE(left);
  });
  go_on.count_down();
  stopper.join();
}

TEST_F(CameraThreadTest, CanStopWithoutWaitingOnceIdle) {
  std::latch entered(1), go_on(1);
  hook_ = [&](const CapturedImage&) {
    entered.count_down();
    go_on.wait();
  };
  const auto thread = start({milliseconds(0), milliseconds(0), milliseconds(0)});
  EXPECT_FALSE(thread->try_stop()) << "it was not asked to";
  camera_->play({kImage});
  entered.wait();
  thread->ask_to_stop();
  EXPECT_FALSE(thread->try_stop()) << "a stage is at work, though there is no more patience for a driver";
  go_on.count_down();
  EXPECT_TRUE(test::becomes([&] { return thread->try_stop(); }));
  EXPECT_TRUE(thread->try_stop());
}

TEST_F(CameraThreadTest, OneThatHangsInItsDriverIsLeftBehindWithoutWaiting) {
  camera_->block_closing();
  const auto thread = start(kLeftBehind);
  camera_->wait_for_opened(1);
  thread->ask_to_stop();
  EXPECT_TRUE(test::becomes([&] { return thread->try_stop(); }));
  EXPECT_EQ(camera_->closed(), 0);
  camera_->release();
  camera_->wait_for_closed(1);
}

TEST_F(CameraThreadTest, ContinuesIfTheSystemRefusesThreadSettings) {
  ThreadSettings settings;
  settings.cpu = 1023;
  camera_->play({kImage});
  const auto thread = start(kAtOnce, settings);
  EXPECT_EQ(wait_for(*thread, frames(1)).frames, 1U);
}

TEST_F(CameraThreadTest, AllocatesNothingForAPicture) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  std::vector<FakeCamera::Step> steps(200, kImage);
  std::uint64_t first = 0, last = 0;
  hook_ = [&](const CapturedImage&) {
    last = allocation_count();
    if (taken_ == 100) first = last;
  };
  camera_->play(steps);
  const auto thread = start();
  wait_for(*thread, frames(200));
  thread->stop();
  EXPECT_EQ(last, first);
}

TEST_F(CameraThreadTest, OneThatIsNeverStartedOpensNothing) {
  {
    const auto thread = make();
    EXPECT_EQ(thread->health().state, CameraState::kOpening);
    EXPECT_EQ(thread->health().progress_ns, 0);
    EXPECT_EQ(thread->controls(), nullptr);
  }
  EXPECT_EQ(camera_->attempts(), 0);
}

TEST_F(CameraThreadTest, ItClosesItsPredecessorsCameraBeforeItOpensItsOwn) {
  auto first = start();
  camera_->play({kImage});
  wait_for(*first, frames(1));
  camera_->block_closing();
  const auto second = make();
  second->start(std::move(first));
  EXPECT_EQ(second->health().state, CameraState::kOpening);
  camera_->release();
  camera_->play_forever(kImage);
  EXPECT_GT(wait_for(*second, some_frames).frames, 0U);
  EXPECT_EQ(camera_->wait_for_opened(2), 2);
  EXPECT_EQ(camera_->closed(), 1);
}

TEST_F(CameraThreadTest, APredecessorThatDoesNotCloseIsLeftBehind) {
  auto first = start(kLeftBehind);
  camera_->wait_for_opened(1);
  camera_->block_closing();
  const auto second = make();
  second->start(std::move(first));
  camera_->play_forever(kImage);
  EXPECT_GT(wait_for(*second, some_frames).frames, 0U);
  EXPECT_EQ(camera_->closed(), 0);
  camera_->release();
  camera_->wait_for_closed(1);
}

TEST_F(CameraThreadTest, SuccessorsDeliverImagesOneAtATime) {
  std::latch entered(1), go_on(1);
  std::atomic<int> inside{0}, max_inside{0};
  hook_ = [&](const CapturedImage&) {
    max_inside = std::max(max_inside.load(), ++inside);
    if (taken_ == 1) {
      entered.count_down();
      go_on.wait();
    }
    --inside;
  };
  auto thread = start();
  camera_->play_forever(kImage);
  entered.wait();
  for (int i = 0; i < 3; ++i) {
    auto next = make();
    next->start(std::move(thread));
    thread = std::move(next);
  }
  EXPECT_EQ(camera_->attempts(), 1) << "the first one is still in its on_image";
  go_on.count_down();
  wait_for(*thread, [](const CameraHealth& health) { return health.frames >= 10; });
  EXPECT_EQ(max_inside, 1);
}

TEST_F(CameraThreadTest, StopWaitsForAPictureThatAPredecessorProcesses) {
  std::latch entered(1), go_on(1);
  std::atomic<bool> left{false};
  hook_ = [&](const CapturedImage&) {
    entered.count_down();
    go_on.wait();
    left = true;
  };
  auto first = start();
  camera_->play({kImage});
  entered.wait();
  const auto second = make();
  second->start(std::move(first));
  std::thread stopper([&] {
    second->stop();
    EXPECT_TRUE(left);
  });
  go_on.count_down();
  stopper.join();
}

TEST_F(CameraThreadTest, ReportsIdlenessAndClosing) {
  auto thread = start({std::chrono::hours(1), std::chrono::hours(1)});
  buffers_are_out_ = true;
  EXPECT_TRUE(test::becomes([&] { return idle_calls_ >= 5; }));
  buffers_are_out_ = false;
  camera_->play({lost("no heartbeat")});
  wait_for(*thread, state(CameraState::kLost));
  camera_->wait_for_closed(1);
  const int before = idle_calls_;
  EXPECT_GE(before, 6);
  thread->stop();
  EXPECT_EQ(idle_calls_, before);
}

TEST_F(CameraThreadTest, AThreadThatIsHeldWhileItAsksForTheHealthDelaysNoPicture) {
  const auto thread = start();
  camera_->play_forever(kImage);
  wait_for(*thread, some_frames);
  expect_never_waits(
      [&] {
        (void)thread->health();
        (void)thread->controls();
      },
      [&] {
        for (const int before = taken_; taken_ < before + 3;) std::this_thread::yield();
      });
}

}  // namespace
}  // namespace sslv::camera_thread_test
