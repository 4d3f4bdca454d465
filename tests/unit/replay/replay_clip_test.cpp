// SPDX-License-Identifier: Apache-2.0
// The same frames yield the same packets: after recording, from the middle of a run, and on another CPU.
#include "replay/replay_clip.h"

#include "colors/table_in_light.h"
#include "config/stages.h"
#include "support/live_run.h"
#include "support/simd_target.h"
#include "support/temporary_folder.h"

#include <algorithm>
#include <random>

#include <gmock/gmock.h>

namespace sslv::replay_clip_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

/// Replays all cameras and returns how many packets equal the live ones.
std::size_t expect_all_exact(const std::filesystem::path& file) {
  std::size_t same = 0;
  ClipReader clip(file);
  for (const ClipReader::Camera& camera : clip.cameras()) {
    ClipReplay replay(clip, camera.id);
    ClipReplay::Result result;
    while (replay.next(result)) {
      EXPECT_TRUE(result.is_exact);
      EXPECT_FALSE(result.packet.empty());
      const bool is_same = std::ranges::equal(result.packet, result.recorded->packet);
      EXPECT_TRUE(is_same) << "camera " << camera.id << ", frame " << result.recorded->info.number;
      same += is_same;
      if (!is_same) break;
    }
    EXPECT_THAT(replay.doubts(), IsEmpty());
  }
  return same;
}

Json with_parameters(Json settings) {
  for (Json& camera : settings["cameras"]) {
    camera["stages"]["detect_robots"] = {{"max_rms_mm", 4}, {"rolling_shutter_ms", 4}};
    camera["stages"]["detect_balls"] = {{"min_confidence", 0.4}};
  }
  return settings;
}

Json with_plain_stages(Json settings) {
  for (Json& camera : settings["cameras"])
    camera["stack"] = {"threshold", "find_runs", "find_regions", "detect_robots", "detect_balls", "publish"};
  return settings;
}

/// Makes every change that a clip can contain, within `seconds`.
void run_with_changes(LiveRun& live, const Json& settings, double seconds) {
  const double part_s = seconds / 5;
  live.run(part_s);
  live.change_settings(with_parameters(settings));
  live.run(part_s);
  live.change_table(std::make_shared<const Lut>(
      table_in_light(*live.setup(0)->context.accepted_lut, {.gain = {0.8, 0.85, 0.9}})));
  live.run(part_s);
  live.change_heights({150, 131.5});
  live.run(part_s);
  live.change_settings(with_plain_stages(settings));
  live.run(part_s);
  live.change_settings(settings);
}

TEST(Replay, GivesTheLivePacketsByteForByte) {
  const test::TemporaryFolder folder;
  const Json settings = live_settings();
  LiveRun live(settings);
  live.begin_clip(folder.file("whole"));
  run_with_changes(live, settings, 2);
  live.end_clip();
  EXPECT_GT(live.robots(), 200u);
  EXPECT_GT(live.balls(), 20u);
  EXPECT_EQ(expect_all_exact(folder.file("whole")), 240u);

  // A clip from the middle of a run: the stages remember earlier frames.
  live.begin_clip(folder.file("middle"));
  run_with_changes(live, settings, 1);
  live.end_clip();
  EXPECT_EQ(expect_all_exact(folder.file("middle")), 120u);
}

/// One minute, in clips that begin in the middle of the run.
TEST(Replay, GivesTheLivePacketsOfAMinute) {
  constexpr int kClips = 12;
  const test::TemporaryFolder folder;
  std::size_t same = 0;
  for (const char* format : {"uyvy", "bayer_rg8"}) {
    const Json settings = live_settings(format);
    LiveRun live(settings);
    for (int clip = 0; clip < kClips; ++clip) {
      live.begin_clip(folder.file("clip"));
      run_with_changes(live, settings, 5);
      live.end_clip();
      same += expect_all_exact(folder.file("clip"));
      std::filesystem::remove(folder.file("clip"));
    }
  }
  EXPECT_EQ(same, 2u * kClips * 2 * 300);
}

TEST(Replay, SaysWhyItIsNotExact) {
  const test::TemporaryFolder folder;
  LiveRun live(live_settings());
  live.run(0.2);
  live.begin_clip(folder.file("clip"), false);
  live.run(0.1);
  live.end_clip();
  {
    ClipReader clip(folder.file("clip"));
    ClipReplay replay(clip, 0);
    ClipReplay::Result result;
    ASSERT_TRUE(replay.next(result));
    EXPECT_FALSE(result.is_exact);
    EXPECT_EQ(result.frame->info.number, 12u);
    EXPECT_THAT(replay.doubts(), ElementsAre("the clip lacks the stages' state before frame 12"));
  }
  live.begin_clip(folder.file("gap"));
  live.run(0.1);
  live.skip_frame();
  live.run(0.1);
  live.end_clip();
  ClipReader clip(folder.file("gap"));
  ClipReplay replay(clip, 1);
  ClipReplay::Result result;
  std::vector<bool> exact;
  while (replay.next(result)) exact.push_back(result.is_exact);
  EXPECT_THAT(exact,
              ElementsAre(true, true, true, true, true, true, false, false, false, false, false, false));
  EXPECT_THAT(replay.doubts(), ElementsAre("frames are missing before frame 25"));
  EXPECT_THAT([&] { ClipReplay(clip, 9); }, ThrowsMessage<ClipError>(HasSubstr("no camera 9; it has 0, 1")));
}

TEST(Replay, OfASpanRestoresTheStagesMemory) {
  const test::TemporaryFolder folder;
  LiveRun live(live_settings());
  live.run(0.5);
  live.begin_clip(folder.file("clip"));
  live.run(1);
  live.end_clip();
  ClipReader clip(folder.file("clip"));
  ClipReplay replay(clip, 0, {.from_s = 0.5, .to_s = 0.7});
  ClipReplay::Result result;
  std::vector<std::uint32_t> numbers;
  while (replay.next(result)) {
    EXPECT_TRUE(result.is_exact);
    EXPECT_TRUE(std::ranges::equal(result.packet, result.recorded->packet));
    numbers.push_back(result.frame->info.number);
  }
  EXPECT_THAT(numbers, testing::SizeIs(testing::AllOf(testing::Ge(12u), testing::Le(13u))));
  EXPECT_GE(numbers.front(), 60u);
  EXPECT_GE(replay.processed(), 40u);
}

TEST(Replay, MayHaveOtherSettings) {
  const test::TemporaryFolder folder;
  Json settings = live_settings();
  LiveRun live(settings);
  live.begin_clip(folder.file("clip"));
  live.run(0.3);
  live.end_clip();
  ClipReader clip(folder.file("clip"));
  settings["cameras"][0]["stages"]["detect_robots"]["min_confidence"] = 1;
  settings["cameras"][0]["stack"] = {"segment", "detect_robots", "detect_balls"};
  ClipReplay replay(clip, 0, {},
                    OtherSetup{std::make_shared<const Config>(read_config(settings)), "new.json"});
  ClipReplay::Result result;
  std::size_t frames = 0;
  while (replay.next(result)) {
    ++frames;
    EXPECT_FALSE(result.is_exact);
    EXPECT_TRUE(result.packet.empty()) << "nothing is published";
    for (const Robot& robot : result.frame->robots.robots) EXPECT_GE(robot.confidence, 1);
  }
  EXPECT_EQ(frames, 18u);
}

/// Simulated frames of one camera, in motion.
struct DrawnFrames {
  explicit DrawnFrames(const char* format, int count, double rate_hz = 60)
      : config(read_config(live_settings(format))) {
    Json source = config.cameras[0].source;
    source.erase("backend");
    SimulatedCamera camera(simulator_options(source, ""), {0, *make_context(config, 0).scene},
                           league_patterns());
    layout = camera.layout();
    for (int i = 0; i < count; ++i) {
      pictures.emplace_back(camera.picture_bytes());
      camera.draw(time_s(i, rate_hz), pictures.back().data());
    }
  }
  static double time_s(int i, double rate_hz = 60) { return 1000 + i / rate_hz; }
  Image image(int i) const {
    ImageView view = layout;
    view.data = pictures[static_cast<std::size_t>(i)].data();
    return {view, nullptr, nullptr, nullptr};
  }

  Config config;
  ImageView layout;
  std::vector<std::vector<std::uint8_t>> pictures;
};

struct FoundSink : DetectionSink {
  void publish(const FrameInfo&, const Scene&, const RobotList&, const BallList&) noexcept override {}
};

/// The default stack's pipeline and its inputs.
struct Detector {
  explicit Detector(const Config& config) {
    const CameraSettings& camera = config.cameras[0];
    setup.pipeline = std::make_shared<Pipeline>(stage_table(), camera.running.stages, "");
    setup.parameters = setup.pipeline->parameters_of(camera.stage_params);
    setup.context = make_context(config, 0);
  }
  const Frame& process(const DrawnFrames& drawn, int i) {
    frame.info.number = static_cast<std::uint32_t>(i);
    frame.info.times.t_capture_s = DrawnFrames::time_s(i);
    frame.image = drawn.image(i);
    setup.pipeline->run({frame, setup.context, sink}, setup.parameters);
    return frame;
  }
  CameraSetup setup;
  FoundSink sink;
  Frame frame;
};

class ReplayOnTarget : public testing::TestWithParam<const char*> {};

TEST_P(ReplayOnTarget, FindsTheSame) {
  constexpr int kFrames = 90;
  const DrawnFrames drawn(GetParam(), kFrames);
  const auto targets = cpu_targets();
  if (targets.size() < 2) GTEST_SKIP() << "this CPU has one set of vector instructions";
  std::vector<RegionList> regions(kFrames);
  std::vector<RobotList> robots(kFrames);
  std::vector<BallList> balls(kFrames);
  std::size_t robots_seen = 0, balls_seen = 0;
  double max_mm = 0, max_rad = 0;
  for (const std::int64_t target : targets) {
    const OnlyTarget only(target);
    Detector detector(drawn.config);
    for (int i = 0; i < kFrames; ++i) {
      const Frame& frame = detector.process(drawn, i);
      const auto at = static_cast<std::size_t>(i);
      if (target == targets.front()) {
        regions[at] = frame.regions, robots[at] = frame.robots, balls[at] = frame.balls;
        robots_seen += frame.robots.robots.size(), balls_seen += frame.balls.balls.size();
        continue;
      }
      const std::string here = name_of_target(target) + ", frame " + std::to_string(i);
      ASSERT_EQ(frame.regions.regions.size(), regions[at].regions.size()) << here;
      for (std::size_t k = 0; k < frame.regions.regions.size(); ++k) {
        const Region &a = regions[at].regions[k], &b = frame.regions.regions[k];
        ASSERT_EQ(std::tie(a.label, a.area_px, a.left, a.top, a.right, a.bottom, a.x_px, a.y_px),
                  std::tie(b.label, b.area_px, b.left, b.top, b.right, b.bottom, b.x_px, b.y_px))
            << here;
      }
      ASSERT_EQ(frame.robots.robots.size(), robots[at].robots.size()) << here;
      for (std::size_t k = 0; k < frame.robots.robots.size(); ++k) {
        // Robots of equal confidence may be in another order.
        const Robot& b = frame.robots.robots[k];
        const auto a = std::ranges::find_if(
            robots[at].robots, [&](const Robot& robot) { return robot.team == b.team && robot.id == b.id; });
        ASSERT_NE(a, robots[at].robots.end()) << here << ": id " << b.id;
        max_mm = std::max(max_mm, std::hypot(a->x_mm - b.x_mm, a->y_mm - b.y_mm));
        max_rad =
            std::max(max_rad, std::abs(std::remainder(a->orientation_rad - b.orientation_rad, 6.283185307)));
      }
      ASSERT_EQ(frame.balls.balls.size(), balls[at].balls.size()) << here;
      for (std::size_t k = 0; k < frame.balls.balls.size(); ++k) {
        const Ball &a = balls[at].balls[k], &b = frame.balls.balls[k];
        max_mm = std::max(max_mm, std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm));
      }
    }
  }
  EXPECT_EQ(max_mm, 0);
  EXPECT_EQ(max_rad, 0);
  EXPECT_GT(robots_seen, 100u);
  EXPECT_GT(balls_seen, 10u);
}

INSTANTIATE_TEST_SUITE_P(Cpu, ReplayOnTarget, testing::Values("uyvy", "rgb24", "bayer_rg8"),
                         [](const auto& tested) { return std::string(tested.param); });

TEST(PipelineMemory, SurvivesArbitraryBytes) {
  constexpr int kLearn = 30, kVariants = 1500;
  const DrawnFrames drawn("uyvy", kLearn + 2);
  Json settings = live_settings();
  settings["cameras"][0]["stages"]["detect_robots"] = {{"rolling_shutter_ms", 5}, {"memory_ms", 2000}};
  const Config config = read_config(settings);
  Detector learned(config);
  for (int i = 0; i < kLearn; ++i) learned.process(drawn, i);
  std::vector<std::byte> saved(1 << 20);
  saved.resize(learned.setup.pipeline->save(saved));
  ASSERT_GT(saved.size(), 300u);
  std::mt19937 random(3);
  const auto below = [&](std::size_t count) { return static_cast<std::size_t>(random()) % count; };
  Detector detector(config);
  int taken = 0;
  for (int variant = 0; variant < kVariants; ++variant) {
    std::vector<std::byte> bytes = saved;
    switch (variant % 4) {
      case 0: bytes[below(bytes.size())] ^= static_cast<std::byte>(1U << random() % 8); break;
      case 1:  // 20 random 8-byte values
        for (int i = 0; i < 20; ++i) {
          const std::size_t at = below(bytes.size() / 8) * 8;
          for (std::size_t k = 0; k < 8 && at + k < bytes.size(); ++k)
            bytes[at + k] = static_cast<std::byte>(random());
        }
        break;
      case 2: bytes.resize(below(bytes.size())); break;
      default:
        for (std::byte& byte : bytes) {
          if (random() % 200 == 0) byte = static_cast<std::byte>(random());
        }
        break;
    }
    taken += detector.setup.pipeline->restore(bytes).empty();
    detector.process(drawn, kLearn + variant % 2);
  }
  EXPECT_GT(taken, kVariants / 20);
  EXPECT_LT(taken, kVariants);

  // A valid memory is still restored afterwards.
  EXPECT_THAT(detector.setup.pipeline->restore(saved), IsEmpty());
  const RobotList expected = learned.process(drawn, kLearn).robots;
  const RobotList& found = detector.process(drawn, kLearn).robots;
  ASSERT_EQ(found.robots.size(), expected.robots.size());
  for (std::size_t i = 0; i < found.robots.size(); ++i)
    EXPECT_EQ(found.robots[i].x_mm, expected.robots[i].x_mm);
}

}  // namespace
}  // namespace sslv::replay_clip_test
