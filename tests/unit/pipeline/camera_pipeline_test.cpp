// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera_pipeline.h"

#include "pipeline/publish.h"
#include "support/allocation_count.h"
#include "support/held_thread.h"
#include "vision/detect_balls.h"
#include "vision/detect_robots.h"
#include "vision/find_regions.h"
#include "vision/find_runs.h"
#include "vision/segment.h"
#include "vision/threshold.h"

#include <array>
#include <atomic>
#include <functional>
#include <random>
#include <semaphore>
#include <thread>

#include <gmock/gmock.h>

namespace sslv::camera_pipeline_test {
namespace {

using ::testing::ElementsAre;

struct CountingSink : DetectionSink {
  void publish(const FrameInfo& info, const Scene&, const RobotList& list,
               const BallList&) noexcept override {
    last_number = info.number;
    robots += list.robots.size();
    ++packets;
  }
  std::uint32_t last_number = 0;
  std::size_t packets = 0, robots = 0;
};

/// Marks each frame with its parameter, the number of balls.
struct Mark {
  struct Params {
    int balls = 0;
    static constexpr auto fields() {
      return std::tuple{number("balls", &Params::balls, 0, 100, "", "so many")};
    }
  };
  void process(const Params& params, const Image&, BallList& out, RobotList& robots) noexcept {
    out.balls.assign(static_cast<std::size_t>(params.balls), Ball{});
    robots.robots.clear();
  }
};

const std::array kTable{stage<Mark>("mark", ""),
                        stage<Publish>("publish", ""),
                        stage<Segment>("segment", ""),
                        stage<Threshold>("threshold", ""),
                        stage<FindRuns>("find_runs", ""),
                        stage<FindRegions>("find_regions", ""),
                        stage<DetectRobots>("detect_robots", ""),
                        stage<DetectBalls>("detect_balls", "")};

CameraSetup setup_of(const std::vector<std::string>& stack, const Json& stages = Json::object()) {
  CameraSetup setup;
  setup.pipeline = std::make_shared<Pipeline>(kTable, stack, "/stack");
  setup.parameters = setup.pipeline->make_parameters(stages, "/stages");
  setup.context = {std::make_shared<Scene>(), std::make_shared<Lut>(), std::make_shared<Mask>(),
                   std::make_shared<PatternTable>(league_patterns())};
  return setup;
}

TEST(CameraPipeline, NumbersPublishesAndOffersEveryFrame) {
  CountingSink sink;
  CameraPipeline camera(7, sink, setup_of({"mark", "publish"}));
  for (std::uint32_t i = 0; i < 5; ++i) {
    const Frame& frame = camera.process({}, {100.0 + i});
    EXPECT_EQ(frame.info.camera_id, 7u);
    EXPECT_EQ(frame.info.number, i);
    EXPECT_EQ(frame.stage_ns.size(), 2u);
    const auto offered = camera.finished().peek();
    ASSERT_TRUE(offered);
    EXPECT_EQ(&*offered->value, &frame);
  }
  EXPECT_EQ(sink.packets, 5u);
  EXPECT_EQ(sink.last_number, 4u);
  EXPECT_EQ(camera.counters().frames, 5u);
}

TEST(CameraPipeline, ANewSetupTakesEffectWithTheNextFrame) {
  CountingSink sink;
  CameraPipeline camera(0, sink, setup_of({"mark", "publish"}));
  EXPECT_EQ(camera.process({}, {}).balls.balls.size(), 0u);
  camera.change(setup_of({"mark", "publish"}, {{"mark", {{"balls", 3}}}}));
  EXPECT_EQ(camera.process({}, {}).balls.balls.size(), 3u);
  EXPECT_EQ(camera.counters().balls, 3u);
}

TEST(CameraPipeline, PartsOfRemovedStagesAreCleared) {
  CountingSink sink;
  CameraPipeline camera(0, sink, setup_of({"segment", "mark"}, {{"mark", {{"balls", 3}}}}));
  std::vector<std::uint8_t> pixels(8 * 4 * 2);
  const auto picture = [&] {
    return Image({pixels.data(), 8, 4, 16, PixelFormat::kUyvy}, nullptr, nullptr, nullptr);
  };
  for (int i = 0; i < 20; ++i) EXPECT_EQ(camera.process(picture(), {}).runs.width, 8);
  camera.change(setup_of({}));
  for (int i = 0; i < 20; ++i) {
    const Frame& frame = camera.process(picture(), {});
    EXPECT_EQ(frame.runs.width, 0);
    EXPECT_TRUE(frame.balls.balls.empty());
  }
  EXPECT_EQ(camera.counters().balls, 0u);
}

TEST(CameraPipeline, ViewersThatHoldAllFramesCostNoDetection) {
  CountingSink sink;
  CameraPipeline camera(0, sink, setup_of({"mark", "publish"}));
  std::vector<FrameRef> held;
  for (int i = 0; i < 20; ++i) {
    camera.process({}, {});
    held.push_back(camera.finished().peek()->value);
  }
  EXPECT_EQ(sink.packets, 20u);
  const auto unseen = camera.counters().unseen;
  EXPECT_GT(unseen, 10u);
  held.clear();
  camera.process({}, {});
  EXPECT_EQ(camera.counters().unseen, unseen);
}

TEST(CameraPipeline, FramesInTheSpareSlotReturnTheirBufferAtOnce) {
  CountingSink sink;
  CameraPipeline camera(0, sink, setup_of({"mark", "publish"}));
  int buffers_out = 0;
  const auto picture = [&] {
    ++buffers_out;
    return Image({}, &buffers_out, nullptr, [](void* owner, void*) noexcept { --*static_cast<int*>(owner); });
  };
  std::vector<FrameRef> held;
  for (int i = 0; i < 20; ++i) {
    camera.process(picture(), {});
    held.push_back(camera.finished().peek()->value);
  }
  EXPECT_LE(buffers_out, 9);
  held.clear();
  camera.close();
  camera.process({}, {});
  EXPECT_LE(buffers_out, 1);
}

/// Counts lent buffers, and those returned by a thread other than the camera's.
struct Driver {
  Image lend() {
    ++lent;
    return {{}, this, nullptr, [](void* owner, void*) noexcept {
              auto& driver = *static_cast<Driver*>(owner);
              --driver.lent;
              driver.by_others += std::this_thread::get_id() != driver.cameras_thread;
            }};
  }
  const std::thread::id cameras_thread = std::this_thread::get_id();
  std::atomic<int> lent{0}, by_others{0};
};

TEST(CameraPipeline, FramesReleasedByViewersAreReturnedByTheCamerasThread) {
  CountingSink sink;
  Driver driver;
  CameraPipeline camera(0, sink, setup_of({"mark", "publish"}));
  camera.process(driver.lend(), {});
  FrameRef held = camera.finished().peek()->value;
  camera.process(driver.lend(), {});
  EXPECT_EQ(driver.lent, 2);
  EXPECT_TRUE(camera.give_back());
  std::thread([&] { held.reset(); }).join();
  EXPECT_EQ(driver.by_others, 0);
  EXPECT_FALSE(camera.give_back()) << "only the newest one is out";
  EXPECT_EQ(driver.lent, 1);
  camera.close();
  EXPECT_EQ(driver.lent, 0);
}

/// Blocks in publish() until the test continues.
struct WaitingSink : DetectionSink {
  void publish(const FrameInfo&, const Scene&, const RobotList&, const BallList&) noexcept override {
    entered.release();
    go_on.acquire();
  }
  std::binary_semaphore entered{0}, go_on{0};
};

TEST(CameraPipeline, AReplacedSetupIsNotFreedByTheCamerasThread) {
  WaitingSink sink;
  std::thread::id freed_by;
  CameraSetup setup = setup_of({"mark", "publish"});
  setup.context.adapted_lut = std::shared_ptr<const Lut>(new Lut(), [&](const Lut* lut) {
    freed_by = std::this_thread::get_id();
    delete lut;
  });
  CameraPipeline camera(0, sink, std::move(setup));
  std::thread cameras_thread([&] { camera.process({}, {}); });
  sink.entered.acquire();
  camera.change(setup_of({"mark", "publish"}));
  EXPECT_EQ(freed_by, std::thread::id()) << "the frame uses it";
  sink.go_on.release();
  cameras_thread.join();
  EXPECT_EQ(freed_by, std::thread::id());
  (void)camera.setup();
  EXPECT_EQ(freed_by, std::this_thread::get_id());
}

TEST(CameraPipeline, APausedReaderDelaysNoFrame) {
  CountingSink sink;
  const CameraSetup setup = setup_of({"mark", "publish"});
  CameraPipeline camera(0, sink, setup);
  const auto process = [&] {
    for (int i = 0; i < 3; ++i) camera.process({}, {});
  };
  for (int i = 0; i < 20; ++i) process();  // until the lists of all slots have grown
  std::uint64_t seen = 0;
  const std::vector<std::function<void()>> looks{
      [&] { (void)camera.finished().peek(); },
      [&] {
        const auto newest = camera.finished().wait_newer(seen, std::chrono::milliseconds(1));
        if (newest) seen = newest->version;
      },
      [&] { (void)camera.setup(); },
      [&] { camera.change(setup); },
      [&] { (void)camera.counters(); },
  };
  for (const auto& look : looks) expect_never_waits(look, process, 400);
  EXPECT_EQ(camera.counters().unseen, 0u);
}

TEST(CameraPipeline, TheWholeStackAllocatesNothingPerFrame) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  // Two of every eight cells have a colour label: random images give many runs, regions and dots.
  std::vector<Label> table(Lut::kEntries);
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = i % 8 < 6 ? label::kClear : static_cast<Label>(2 + i % 6);
  const auto lut = std::make_shared<Lut>(std::move(table));
  CameraCalibration calibration;
  calibration.principal_point_x = 100, calibration.principal_point_y = 80;
  calibration.q0 = 1, calibration.q3 = 0, calibration.tz = 4000;
  auto scene = std::make_shared<Scene>();
  scene->camera.emplace(calibration);

  std::mt19937 random(1);
  std::array<std::vector<std::uint8_t>, 5> pictures;
  for (auto& picture : pictures) {
    picture.resize(200 * 160 * 2);
    for (auto& byte : picture) byte = static_cast<std::uint8_t>(random());
  }
  using Stack = std::vector<std::string>;
  for (const Stack& stack :
       {Stack{"segment", "detect_robots", "detect_balls", "publish"},
        Stack{"threshold", "find_runs", "find_regions", "detect_robots", "detect_balls", "publish"}}) {
    CountingSink sink;
    CameraSetup setup = setup_of(stack);
    setup.context.adapted_lut = lut;
    setup.context.scene = scene;
    CameraPipeline camera(0, sink, setup);
    const auto run = [&](int frames) {
      for (int i = 0; i < frames; ++i) {
        const ImageView view{pictures[static_cast<std::size_t>(i) % pictures.size()].data(), 200, 160, 400,
                             PixelFormat::kUyvy};
        camera.process(Image(view, nullptr, nullptr, nullptr), {});
      }
    };
    run(100);  // until the lists of all slots are large enough
    const auto before = allocation_count();
    run(1000);
    EXPECT_EQ(allocation_count() - before, 0u) << stack.front();
  }
}

}  // namespace
}  // namespace sslv::camera_pipeline_test
