// SPDX-License-Identifier: Apache-2.0
#include "pipeline/validate.h"

#include "pipeline/pipeline.h"
#include "pipeline/publish.h"
#include "support/allocation_count.h"

#include <array>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::validate_test {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

Robot robot_of(int id) {
  return {Team::kBlue, id, 100.0 * id, -200, 1.5, 140, 30, 40, 0.9};
}

Ball ball_at(double x_mm) {
  return {x_mm, 10, 50, 60, 30, 0.8};
}

std::vector<int> ids_of(const RobotList& list) {
  std::vector<int> out;
  for (const Robot& robot : list.robots) out.push_back(robot.id);
  return out;
}

/// How many of five robots are dropped if `spoil` changes the third.
std::uint64_t dropped_with(const std::function<void(Robot&)>& spoil) {
  RobotList list;
  for (int id = 0; id < 5; ++id) list.robots.push_back(robot_of(id));
  spoil(list.robots[2]);
  const InvalidCounts dropped = drop_invalid(list);
  if (dropped.robots == 1) {
    EXPECT_THAT(ids_of(list), ElementsAre(0, 1, 3, 4));
  }
  EXPECT_EQ(dropped.balls + dropped.others, 0U);
  return dropped.robots;
}

TEST(InvalidCounts, CountRobotsWithInvalidNumbers) {
  EXPECT_EQ(dropped_with([](Robot&) {}), 0U);
  for (const auto number : {&Robot::x_mm, &Robot::y_mm, &Robot::orientation_rad, &Robot::height_mm,
                            &Robot::pixel_x, &Robot::pixel_y, &Robot::confidence}) {
    for (const double bad : {kNan, kInfinite, -kInfinite, 1.1e6, -1.1e6})
      EXPECT_EQ(dropped_with([&](Robot& robot) { robot.*number = bad; }), 1U) << bad;
  }
}

TEST(InvalidCounts, CountRobotsWithUnknownIds) {
  for (const int id : {0, 255}) EXPECT_EQ(dropped_with([&](Robot& robot) { robot.id = id; }), 0U);
  for (const int id : {-1, 256, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()})
    EXPECT_EQ(dropped_with([&](Robot& robot) { robot.id = id; }), 1U) << id;
  EXPECT_EQ(dropped_with([](Robot& robot) { robot.team = static_cast<Team>(2); }), 1U);
}

TEST(InvalidCounts, CountConfidencesOutOfRange) {
  for (const double good : {0.0, 1.0})
    EXPECT_EQ(dropped_with([&](Robot& robot) { robot.confidence = good; }), 0U);
  for (const double bad : {-0.01, 1.01})
    EXPECT_EQ(dropped_with([&](Robot& robot) { robot.confidence = bad; }), 1U);
}

TEST(InvalidCounts, ExcludeUnknownCovariances) {
  for (const double unknown : {kNan, kInfinite}) {
    EXPECT_EQ(dropped_with([&](Robot& robot) { robot.place_cov.xx_mm2 = unknown; }), 0U);
    EXPECT_EQ(dropped_with([&](Robot& robot) { robot.orientation_sigma_rad = unknown; }), 0U);
  }
}

TEST(InvalidCounts, CountBallsWithInvalidNumbers) {
  for (const auto number : {&Ball::x_mm, &Ball::y_mm, &Ball::pixel_x, &Ball::pixel_y, &Ball::confidence}) {
    BallList list{{ball_at(1), ball_at(2), ball_at(3)}};
    list.balls[1].*number = kNan;
    EXPECT_EQ(drop_invalid(list).balls, 1U);
    ASSERT_THAT(list.balls, SizeIs(2));
    EXPECT_EQ(list.balls[1].x_mm, 3);
  }
}

TEST(InvalidCounts, CountEntriesBeyondTheLimits) {
  RobotList robots;
  robots.robots.assign(limits::kMaxRobots + 7, robot_of(3));
  robots.second_robots.assign(limits::kMaxRobots + 2, robot_of(4));
  robots.robots.front().id = 1;
  EXPECT_EQ(drop_invalid(robots).robots, 9U);
  EXPECT_THAT(robots.robots, SizeIs(limits::kMaxRobots));
  EXPECT_EQ(robots.robots.front().id, 1);
  BallList balls{std::vector<Ball>(5000, ball_at(1))};
  EXPECT_EQ(drop_invalid(balls).balls, 5000 - limits::kMaxBalls);
}

TEST(InvalidCounts, LeaveOutInvalidMisses) {
  const RobotMiss good{RobotMiss::Why::kDots, 10, 20, 30, 3, 5, 0, 0};
  for (double RobotMiss::*number : {&RobotMiss::pixel_x, &RobotMiss::pixel_y, &RobotMiss::radius_px,
                                    &RobotMiss::value, &RobotMiss::limit}) {
    RobotList list;
    list.misses.assign(limits::kMaxMisses + 3, good);
    list.misses[0].*number = kNan;
    list.misses[1].why = static_cast<RobotMiss::Why>(99);
    EXPECT_EQ(drop_invalid(list).robots, 0U) << "they are no results";
    EXPECT_THAT(list.misses, SizeIs(limits::kMaxMisses));
    EXPECT_EQ(list.misses[0].pixel_x, 10);
    EXPECT_EQ(list.misses[1].why, RobotMiss::Why::kDots);
  }
}

TEST(InvalidCounts, CountInvalidTracksAndTimes) {
  TrackedField tracked{.number = 1,
                       .t_s = 100,
                       .robots = std::vector<TrackedRobot>(3),
                       .balls = std::vector<TrackedBall>(2),
                       .kick = TrackedKick{}};
  EXPECT_FALSE(drop_invalid(tracked).any());
  tracked.robots[1].velocity_mm_s.x() = kNan;
  tracked.balls[0].place_mm.z() = kInfinite;
  tracked.kick->stop_s = kNan;
  const InvalidCounts dropped = drop_invalid(tracked);
  EXPECT_EQ(dropped.robots, 1U);
  EXPECT_EQ(dropped.balls, 1U);
  EXPECT_EQ(dropped.others, 1U);
  EXPECT_FALSE(tracked.kick);
  tracked.t_s = kNan;
  EXPECT_EQ(drop_invalid(tracked).robots, 2U);
  EXPECT_EQ(tracked.t_s, 0);
  EXPECT_THAT(tracked.robots, SizeIs(0));

  ImageTime time{kNan, 1};
  EXPECT_EQ(drop_invalid(time).others, 1U);
  EXPECT_FALSE(time.t_s);
  EXPECT_FALSE(drop_invalid(time).any()) << "an image that is left out has none";
}

CameraSightings image_of(std::size_t robots) {
  CameraSightings image;
  image.t_capture_s = 100;
  image.camera_mm = {0, 0, 4000};
  for (std::size_t i = 0; i < robots; ++i) {
    image.robots.push_back(
        {Team::kBlue, static_cast<int>(i), {100, 200}, 0.5, 140, Eigen::Matrix2d::Identity(), 1e-3});
  }
  image.balls.push_back({{1, 2}, Eigen::Matrix2d::Identity(), 0.9});
  return image;
}

TEST(InvalidCounts, CountSightingsWithInvalidNumbers) {
  const auto dropped = [](const std::function<void(CameraSightings&)>& spoil) {
    CameraSightings image = image_of(3);
    spoil(image);
    const InvalidCounts out = drop_invalid(image);
    return out.robots + out.balls + out.others;
  };
  EXPECT_EQ(dropped([](auto&) {}), 0U);
  EXPECT_EQ(dropped([](auto& image) { image.robots[1].place_mm.x() = kNan; }), 1U);
  EXPECT_EQ(dropped([](auto& image) { image.robots[1].orientation_rad = kInfinite; }), 1U);
  EXPECT_EQ(dropped([](auto& image) { image.robots[1].id = 256; }), 1U);
  EXPECT_EQ(dropped([](auto& image) { image.balls[0].place_mm.y() = 2e6; }), 1U);
  EXPECT_EQ(dropped([](auto& image) { image.balls[0].confidence = kNan; }), 1U);
  for (const double height_mm : {-1.0, 1001.0, kNan})
    EXPECT_EQ(dropped([&](auto& image) { image.robots[1].height_mm = height_mm; }), 1U) << height_mm;
  EXPECT_EQ(dropped([](auto& image) {
              image.camera_mm.z() = 500;
              image.robots[1].height_mm = 400;
            }),
            1U)
      << "no camera sees the top of what is as high as itself";
}

TEST(InvalidCounts, CountImagesWithInvalidPositionsOrTimes) {
  for (const auto& spoil : std::vector<std::function<void(CameraSightings&)>>{
           [](auto& image) { image.t_capture_s = kNan; }, [](auto& image) { image.camera = -1; },
           [](auto& image) { image.camera = 256; }, [](auto& image) { image.camera_mm.z() = 0; },
           [](auto& image) { image.camera_mm.x() = kNan; }, [](auto& image) { image.camera_mm.z() = 1e6; }}) {
    CameraSightings image = image_of(3);
    spoil(image);
    const InvalidCounts dropped = drop_invalid(image);
    EXPECT_EQ(dropped.robots, 3U);
    EXPECT_EQ(dropped.balls, 1U);
    EXPECT_EQ(dropped.others, 1U);
    EXPECT_FALSE(image.is_taken);
    EXPECT_THAT(image.robots, SizeIs(0));
  }
}

TEST(InvalidCounts, CountSightingsBeyondTheLimitsOfAnImage) {
  CameraSightings image = image_of(200);
  image.balls.resize(200, image.balls[0]);
  const InvalidCounts dropped = drop_invalid(image);
  EXPECT_EQ(dropped.robots, 200 - limits::kMaxRobots);
  EXPECT_EQ(dropped.balls, 200 - limits::kMaxFieldBalls);
}

TEST(InvalidCounts, ExcludeBallsOfUnknownHeight) {
  Observations seen;
  seen.balls.push_back({.t_s = 1,
                        .camera_mm = {0, 0, 4000},
                        .place_mm = {1, 2},
                        .sigma_mm = 1,
                        .height_mm = kNan,
                        .height_sigma_mm = kInfinite});
  seen.robots.push_back({.name = {},
                         .camera = 0,
                         .t_s = 1,
                         .t_sigma_s = 0,
                         .place_mm = {1, 2},
                         .orientation_rad = 0,
                         .place_cov_mm2 = Eigen::Matrix2d::Identity(),
                         .orientation_sigma_rad = 0.1});
  EXPECT_FALSE(drop_invalid(seen).any());
  seen.balls[0].height_sigma_mm = 5;
  seen.robots[0].place_cov_mm2(0, 1) = kNan;
  const InvalidCounts dropped = drop_invalid(seen);
  EXPECT_EQ(dropped.balls, 1U);
  EXPECT_EQ(dropped.robots, 1U);
}

struct NoParams {
  static constexpr auto fields() { return std::tuple{}; }
};

/// Makes robots 0 to 4; robots 2 and 3 have no valid position.
struct MakeBad {
  using Params = NoParams;
  void process(const Params&, RobotList& robots, BallList& balls) noexcept {
    robots.robots.clear();
    for (int id = 0; id < 5; ++id) robots.robots.push_back(robot_of(id));
    robots.robots[2].x_mm = robots.robots[3].y_mm = kNan;
    balls.balls.clear();
  }
};

/// Counts the robots that it gets, then makes another robot and the time invalid.
struct SpoilOne {
  using Params = NoParams;
  void process(const Params&, Update<RobotList> robots, Update<FrameInfo> info) noexcept {
    seen = robots->robots.size();
    robots->robots.front().confidence = 7;
    info->times.t_capture_s = kNan;
  }
  static inline std::size_t seen = 0;
};

/// Publishes invalid lists of its own, which are not in the frame.
struct PublishOwn {
  using Params = NoParams;
  RobotList own;
  BallList balls;
  void process(const Params&, const FrameInfo& info, const Scene& scene, DetectionSink& sink) noexcept {
    own.robots.assign(300, robot_of(1));
    own.robots[0].id = -1;
    balls.balls.assign(2, ball_at(kInfinite));
    sink.publish(info, scene, own, balls);
    FrameInfo no_time = info;
    no_time.times.t_capture_s = kNan;
    sink.publish(no_time, scene, own, balls);
  }
};

struct Sink : DetectionSink {
  void publish(const FrameInfo& info, const Scene&, const RobotList& r, const BallList& b) noexcept override {
    t_capture_s = info.times.t_capture_s;
    robots = r.robots.size();
    balls = b.balls.size();
    ++packets;
  }
  void left_out(std::size_t stage, const InvalidCounts& what) noexcept override { counts[stage] += what; }
  double t_capture_s = 0;
  std::size_t robots = 0, balls = 0, packets = 0;
  std::array<InvalidCounts, 4> counts{};
};

const std::array kTable{stage<SpoilOne>("spoil_one", ""), stage<MakeBad>("make_bad", ""),
                        stage<PublishOwn>("publish_own", ""), stage<Publish>("publish", "")};

class InvalidStack : public testing::Test {
 protected:
  void run(Pipeline& pipeline) {
    frame_.info.times.t_capture_s = 1000;
    pipeline.run({frame_, context_, sink_}, pipeline.make_parameters(Json::object(), ""));
  }
  Frame frame_;
  CameraContext context_{std::make_shared<Scene>(), std::make_shared<Lut>(), std::make_shared<Mask>(),
                         std::make_shared<PatternTable>()};
  Sink sink_;
};

TEST_F(InvalidStack, DropsInvalidOutputBeforeTheNextStage) {
  Pipeline pipeline(kTable, {"make_bad", "spoil_one", "publish"}, "");
  run(pipeline);
  EXPECT_EQ(SpoilOne::seen, 3U);
  EXPECT_EQ(sink_.robots, 2U);
  EXPECT_EQ(sink_.t_capture_s, 1000);
  EXPECT_THAT(ids_of(frame_.robots), ElementsAre(1, 4)) << "what viewers get";
  EXPECT_EQ(pipeline.left_out(0).robots, 2U);
  EXPECT_EQ(pipeline.left_out(1).robots, 1U);
  EXPECT_EQ(pipeline.left_out(1).others, 1U) << "the time";
  EXPECT_FALSE(pipeline.left_out(2).any());
  EXPECT_EQ(sink_.counts[1].robots, 2U) << "by the place in the table";
  EXPECT_EQ(sink_.counts[0].robots, 1U);
}

/// Changes the frame's info.
struct ChangeInfo {
  using Params = NoParams;
  void process(const Params&, Update<FrameInfo> info, DetectionSink&) noexcept { change(*info); }
  static inline std::function<void(FrameInfo&)> change;
};

TEST_F(InvalidStack, RestoresChangedFrameInfo) {
  const std::array table{stage<ChangeInfo>("change_info", ""), stage<MakeBad>("make_bad", ""),
                         stage<Publish>("publish", "")};
  Pipeline pipeline(table, {"change_info", "make_bad", "publish"}, "");
  std::uint64_t restored = 0;
  const auto time_with = [&](const std::function<void(FrameInfo&)>& change) {
    ChangeInfo::change = change;
    run(pipeline);
    const std::uint64_t before = std::exchange(restored, pipeline.left_out(0).others);
    EXPECT_EQ(frame_.info.camera_id, 0U);
    EXPECT_EQ(frame_.info.number, 0U);
    EXPECT_EQ(frame_.info.whole.x, 0);
    return std::pair(sink_.t_capture_s, restored - before);
  };
  using testing::Pair;
  EXPECT_THAT(time_with([](FrameInfo& info) { info.times.t_capture_s += 0.2; }), Pair(1000.2, 0U))
      << "a time may be corrected";
  const std::vector<std::function<void(FrameInfo&)>> bad{
      [](FrameInfo& info) { info.camera_id = 77; },
      [](FrameInfo& info) { info.number = 5; },
      [](FrameInfo& info) { info.times.t_capture_s = 1e300; },
      [](FrameInfo& info) { info.times.t_capture_s = 0; },
      [](FrameInfo& info) { info.times.t_capture_s -= 10; },
      [](FrameInfo& info) { info.times.t_capture_sigma_s = -1; },
      [](FrameInfo& info) { info.times.arrived_ns = std::numeric_limits<std::int64_t>::min(); },
      [](FrameInfo& info) {
        info.whole = {-5, 1 << 30, 1 << 30, -7};
      },
  };
  for (std::size_t i = 0; i < bad.size(); ++i) EXPECT_THAT(time_with(bad[i]), Pair(1000, 1U)) << i;
}

TEST_F(InvalidStack, DropsInvalidOutputFromAStagesOwnList) {
  Pipeline pipeline(kTable, {"publish_own"}, "");
  run(pipeline);
  EXPECT_EQ(sink_.packets, 1U) << "none without a time";
  EXPECT_EQ(sink_.robots, limits::kMaxRobots);
  EXPECT_EQ(sink_.balls, 0U);
  EXPECT_EQ(pipeline.left_out(0).robots, 300 - limits::kMaxRobots + 300);
  EXPECT_EQ(pipeline.left_out(0).balls, 4U);
  EXPECT_EQ(pipeline.left_out(0).others, 1U);
}

TEST_F(InvalidStack, AllocatesNothing) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  Pipeline pipeline(kTable, {"make_bad", "publish_own", "publish"}, "");
  const auto parameters = pipeline.make_parameters(Json::object(), "");
  const auto run = [&] { pipeline.run({frame_, context_, sink_}, parameters); };
  run();
  const auto before = allocation_count();
  for (int i = 0; i < 10; ++i) run();
  EXPECT_EQ(allocation_count() - before, 0U);
}

/// Makes three robot tracks, one without a valid position; without `has_time`, none has a time.
struct MakeTracks {
  struct Params {
    bool has_time = true;
    static constexpr auto fields() { return std::tuple{flag("has_time", &Params::has_time, "")}; }
  };
  void process(const Params& params, const ArrivedSightings&, TrackedField& out) noexcept {
    out.t_s = params.has_time ? 50 : kNan;
    out.robots.assign(3, {});
    out.robots[1].place_mm.x() = kInfinite;
    out.balls.assign(1, {});
  }
};

struct TrackSink : FieldSink {
  void publish(const TrackedField& tracked) noexcept override {
    robots = tracked.robots.size();
    ++packets;
  }
  std::size_t robots = 0, packets = 0;
};
struct NoClock : FieldClock {
  double now_s() const noexcept override { return 0; }
};

TEST(InvalidTracks, AreNotPublished) {
  const std::array table{field_stage<MakeTracks>("make_tracks", ""),
                         field_stage<PublishField>("publish", "")};
  FieldPipeline pipeline(table, {"make_tracks", "publish"}, "");
  FieldFrame frame;
  const FieldSize field;
  const BallModel ball;
  const NoClock clock;
  TrackSink sink;
  const auto run = [&](const char* stages) {
    pipeline.run({frame, field, ball, clock, sink}, pipeline.make_parameters(Json::parse(stages), ""));
  };
  run("{}");
  EXPECT_EQ(sink.packets, 1U);
  EXPECT_EQ(sink.robots, 2U);
  EXPECT_EQ(pipeline.left_out(0).robots, 1U);
  run(R"({"make_tracks": {"has_time": false}})");
  EXPECT_EQ(sink.packets, 1U);
  EXPECT_EQ(pipeline.left_out(0).robots, 4U);
}

}  // namespace
}  // namespace sslv::validate_test
