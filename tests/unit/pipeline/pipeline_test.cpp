// SPDX-License-Identifier: Apache-2.0
#include "pipeline/pipeline.h"

#include "pipeline/publish.h"

#include <functional>

#include <gmock/gmock.h>

namespace sslv::pipeline_test {
namespace {

// These stages report their inputs in `width` and `height` of their lists.

struct NoParams {
  static constexpr auto fields() { return std::tuple{}; }
};

struct MakeLabels {
  struct Params {
    int level = 7;
    static constexpr auto fields() {
      return std::tuple{number("level", &Params::level, 0, 255, "", "grey level")};
    }
  };
  void process(const Params& params, const Image&, LabelImage& out) noexcept { out.width = params.level; }
};

struct DoubleLabels {
  struct Params {
    double factor = 2;
    static constexpr auto fields() {
      return std::tuple{number("factor", &Params::factor, 1.0, 4.0, "", "how much wider")};
    }
  };
  void process(const Params& params, Update<LabelImage> labels) noexcept {
    labels->width = static_cast<int>(labels->width * params.factor);
  }
};

struct FindRuns {
  using Params = NoParams;
  void process(const Params&, const LabelImage& labels, RunList& out) noexcept { out.width = labels.width; }
};

struct FindRegions {
  using Params = NoParams;
  void process(const Params&, const RunList&, RegionList&) noexcept {}
};

/// Outputs one robot per run so far, and a ball with the camera's constants.
struct Count {
  using Params = NoParams;
  int ran = 0;
  void process(const Params&, const Scene& scene, const Lut&, const PatternTable& patterns, RobotList& robots,
               BallList& balls) noexcept {
    robots.robots.assign(static_cast<std::size_t>(++ran), Robot{});
    balls.balls.assign(1, Ball{scene.field.ball_radius, patterns.center_diameter_mm, 0, 0, 0, 0});
  }
};

const std::array kTable{stage<MakeLabels>("make_labels", "first"),
                        stage<DoubleLabels>("double_labels", ""),
                        stage<FindRuns>("find_runs", ""),
                        stage<FindRegions>("find_regions", ""),
                        stage<Count>("count", ""),
                        stage<Publish>("publish", "last")};

struct Sink : DetectionSink {
  std::size_t robots = 0, balls = 0;
  std::uint32_t number = 0;
  void publish(const FrameInfo& info, const Scene&, const RobotList& r, const BallList& b) noexcept override {
    number = info.number;
    robots = r.robots.size();
    balls = b.balls.size();
  }
};

std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no error";
}

std::string stack_error(const std::vector<std::string>& stack) {
  return error_of([&] { Pipeline(kTable, stack, "/cameras/0/stack"); });
}

std::string settings_error(const char* stages) {
  return error_of([&] {
    Pipeline(kTable, {"make_labels"}, "").make_parameters(Json::parse(stages), "/cameras/0/stages");
  });
}

class PipelineRun : public testing::Test {
 protected:
  void run(Pipeline& pipeline, const char* stages = "{}") {
    pipeline.run({frame_, context_, sink_}, pipeline.make_parameters(Json::parse(stages), ""));
  }

  Frame frame_;
  CameraContext context_{std::make_shared<Scene>(), std::make_shared<Lut>(), std::make_shared<Mask>(),
                         std::make_shared<PatternTable>()};
  Sink sink_;
};

TEST(Stage, SignatureSaysWhatItReadsAndWrites) {
  const auto part = [](std::size_t index) { return PartSet{}.set(index); };
  EXPECT_EQ(kTable[0].reads, part(part_index<CameraFloor, Image>()));
  EXPECT_EQ(kTable[0].writes, part(part_index<CameraFloor, LabelImage>()));
  EXPECT_EQ(kTable[1].reads, part(part_index<CameraFloor, LabelImage>()))
      << "an update needs what it changes";
  EXPECT_TRUE(kTable[1].writes.none());
  EXPECT_TRUE(kTable[4].reads.none()) << "the camera's constants are no parts";
  EXPECT_EQ(kTable[4].writes,
            part(part_index<CameraFloor, RobotList>()) | part(part_index<CameraFloor, BallList>()));
}

TEST(PipelineCheck, AcceptsACompleteStack) {
  EXPECT_EQ(stack_error({"make_labels", "double_labels", "find_runs", "find_regions", "count", "publish"}),
            "no error");
  EXPECT_EQ(stack_error({}), "no error");
}

TEST(PipelineCheck, NamesTheMissingPart) {
  EXPECT_EQ(stack_error({"make_labels", "find_regions"}),
            "/cameras/0/stack/1: stage 'find_regions' needs 'runs', which no earlier stage provides");
}

TEST(PipelineCheck, OrderMatters) {
  EXPECT_EQ(stack_error({"find_runs", "make_labels"}),
            "/cameras/0/stack/0: stage 'find_runs' needs 'labels', which no earlier stage provides");
}

TEST(PipelineCheck, AnUpdateNeedsItsPart) {
  EXPECT_EQ(stack_error({"double_labels", "make_labels"}),
            "/cameras/0/stack/0: stage 'double_labels' needs 'labels', which no earlier stage provides");
}

TEST(PipelineCheck, NamesTheUnknownStageAndAllThereAre) {
  EXPECT_EQ(stack_error({"make_labels", "find_rnus"}),
            "/cameras/0/stack/1: unknown stage 'find_rnus'; known: make_labels, double_labels, find_runs, "
            "find_regions, count, publish. A stage of your own needs its library (--stages FOLDER)");
}

TEST(PipelineCheck, RefusesDuplicateStages) {
  EXPECT_EQ(stack_error({"make_labels", "double_labels", "double_labels"}),
            "/cameras/0/stack/1: stage 'double_labels' is in the stack twice");
}

struct OtherLabels {
  using Params = NoParams;
  void process(const Params&, const Image&, LabelImage&) noexcept {}
};
struct NewImage {
  using Params = NoParams;
  void process(const Params&, Image&) noexcept {}
};

TEST(PipelineCheck, RefusesToOverwrite) {
  const std::array table{stage<MakeLabels>("make_labels", ""), stage<OtherLabels>("other_labels", ""),
                         stage<NewImage>("new_image", "")};
  EXPECT_EQ(error_of([&] {
              Pipeline(table, {"make_labels", "other_labels"}, "/stack");
            }),
            "/stack/1: stage 'other_labels' would overwrite 'labels', which 'make_labels' provides");
  EXPECT_EQ(error_of([&] { Pipeline(table, {"new_image"}, "/stack"); }),
            "/stack/0: stage 'new_image' would overwrite 'image', which the camera provides");
}

TEST(PipelineParameters, NameTheMisspeltKey) {
  EXPECT_EQ(settings_error(R"({"make_labels": {"levle": 3}})"),
            "/cameras/0/stages/make_labels/levle: no such parameter; known: level");
  EXPECT_EQ(settings_error(R"({"find_runs": {"level": 3}})"),
            "/cameras/0/stages/find_runs/level: no such parameter; known: none")
      << "stages outside the stack are checked too";
}

TEST(PipelineParameters, NameTheValueThatIsNotAllowed) {
  EXPECT_EQ(
      settings_error(R"({"make_labels": {"level": "bright"}})"),
      "/cameras/0/stages/make_labels/level: \"bright\" is not allowed; expected a whole number 0 .. 255");
  EXPECT_EQ(settings_error(R"({"make_labels": 3})"),
            "/cameras/0/stages/make_labels: 3 is not allowed; expected an object");
  EXPECT_EQ(settings_error("[]"), "/cameras/0/stages: [] is not allowed; expected an object of stages");
}

TEST(PipelineParameters, NameTheUnknownStage) {
  EXPECT_THAT(settings_error(R"({"blur": {}})"),
              testing::StartsWith("/cameras/0/stages/blur: unknown stage 'blur'; known: make_labels,"));
}

TEST(PipelineParameters, AreCompletedForEveryStageOfTheTable) {
  const Json given = Json::parse(R"({"//": "a comment", "double_labels": {"factor": 3}})");
  EXPECT_EQ(read_stages<CameraFloor>(kTable, given, "").complete,
            Json::parse(R"({"make_labels": {"level": 7}, "double_labels": {"factor": 3.0}, "find_runs": {},
                            "find_regions": {}, "count": {}, "publish": {}})"));
}

TEST_F(PipelineRun, StagesSeeWhatEarlierOnesWrote) {
  Pipeline pipeline(kTable, {"make_labels", "double_labels", "find_runs"}, "");
  run(pipeline);
  EXPECT_EQ(frame_.runs.width, 14);
}

TEST_F(PipelineRun, ParametersMayChangeBetweenFrames) {
  Pipeline pipeline(kTable, {"make_labels", "double_labels", "find_runs"}, "");
  const auto first = pipeline.make_parameters(Json::parse(R"({"make_labels": {"level": 10}})"), "");
  const auto second = pipeline.make_parameters(Json::parse(R"({"double_labels": {"factor": 4}})"), "");
  pipeline.run({frame_, context_, sink_}, first);
  EXPECT_EQ(frame_.runs.width, 20);
  pipeline.run({frame_, context_, sink_}, second);
  EXPECT_EQ(frame_.runs.width, 28);
  pipeline.run({frame_, context_, sink_}, first);
  EXPECT_EQ(frame_.runs.width, 20);
}

TEST_F(PipelineRun, StagesRememberAndAreTheirPipelinesOwn) {
  Pipeline one(kTable, {"count"}, ""), other(kTable, {"count"}, "");
  run(one);
  run(one);
  EXPECT_EQ(frame_.robots.robots.size(), 2U);
  run(other);
  EXPECT_EQ(frame_.robots.robots.size(), 1U);
}

TEST_F(PipelineRun, PublishesWhatWasFoundWithTheFramesInfo) {
  Pipeline pipeline(kTable, {"count", "publish"}, "");
  frame_.info.number = 41;
  run(pipeline);
  EXPECT_EQ(sink_.number, 41U);
  EXPECT_EQ(sink_.robots, 1U);
  EXPECT_EQ(sink_.balls, 1U);
}

TEST_F(PipelineRun, StagesSeeTheWorldOfTheirFrame) {
  Pipeline pipeline(kTable, {"count"}, "");
  auto scene = std::make_shared<Scene>();
  scene->field.ball_radius = 33;
  context_.scene = scene;
  run(pipeline);
  EXPECT_EQ(frame_.balls.balls[0].x_mm, 33);
  EXPECT_EQ(frame_.balls.balls[0].y_mm, 50) << "the pattern table's";
}

TEST_F(PipelineRun, EveryStageIsTimed) {
  Pipeline pipeline(kTable, {"make_labels", "find_runs"}, "");
  frame_.stage_ns.assign(5, -1);
  run(pipeline);
  EXPECT_THAT(frame_.stage_ns, testing::ElementsAre(testing::Ge(0), testing::Ge(0)));
  EXPECT_DOUBLE_EQ(pipeline.durations(1).percentiles().p50_us,
                   static_cast<double>(frame_.stage_ns[1]) * 1e-3);
}

}  // namespace
}  // namespace sslv::pipeline_test
