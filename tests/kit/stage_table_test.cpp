// SPDX-License-Identifier: Apache-2.0
// Stages of libraries in the tables and in pipelines.
#include "config/config.h"
#include "config/missing_stages.h"
#include "config/stages.h"
#include "kit/read_stamp.h"
#include "support/allocation_count.h"

#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace sslv::stage_table_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Adds the libraries before anything uses the tables, like a program.
class StageTable : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::vector<std::filesystem::path> folders;
    for (const char* name : {"counting", "same_part", "other_part", "taken_name", "many_parts", "one_place"})
      folders.push_back(std::filesystem::path(SSLV_KIT_LIBRARIES) / name);
    add_stage_libraries({folders, {}}, MissingStages::kLeftOut);
  }

  static Json with_stack(std::vector<std::string> stack, Json stages = Json::object()) {
    return {{"cameras", {{{"id", 3}, {"stack", std::move(stack)}, {"stages", std::move(stages)}}}}};
  }
};

struct NoSink : DetectionSink {
  void publish(const FrameInfo&, const Scene&, const RobotList&, const BallList&) noexcept override {}
};

TEST_F(StageTable, TakesStagesThatFitAndLeavesOutTheRest) {
  std::vector<std::string> names;
  for (const StageType& type : stage_table().subspan(7)) names.push_back(type.library + ":" + type.name);
  EXPECT_THAT(names,
              ElementsAre("counting.so:count_balls", "counting.so:tell_balls", "same_part.so:warn_of_balls"));
  EXPECT_EQ(field_stage_table().back().name, "count_tracks");
  ASSERT_THAT(left_out_libraries(), SizeIs(4));
  EXPECT_EQ(left_out_libraries()[0].why,
            "defines the part 'ball_count' with a different layout than an earlier library");
  EXPECT_EQ(left_out_libraries()[1].why, "has a stage 'threshold', but another stage already has this name");
  EXPECT_THAT(left_out_libraries()[2].why,
              testing::StartsWith("brings the total of libraries' own parts to 61; "));
  EXPECT_THAT(left_out_libraries()[3].why,
              testing::StartsWith("stores its part 'second_of_one_place' and the part 'first_of_one_place' "
                                  "in the same place: build it with hidden visibility"));
}

TEST_F(StageTable, HandsPartsFromOneLibraryToAnother) {
  const std::vector<std::string> stack{"count_balls", "tell_balls", "warn_of_balls"};
  // The frame has no image, so the built-in stages find no balls.
  Pipeline pipeline(stage_table(),
                    {"threshold", "find_runs", "find_regions", "detect_robots", "detect_balls", "count_balls",
                     "tell_balls", "warn_of_balls"},
                    "");
  const auto parameters = pipeline.make_parameters(Json::object(), "");
  Frame frame;
  const CameraContext context{std::make_shared<Scene>(), std::make_shared<Lut>(), std::make_shared<Mask>(),
                              std::make_shared<PatternTable>()};
  NoSink sink;
  pipeline.run({frame, context, sink}, parameters);
  EXPECT_EQ(pipeline.note(6).text, "0 balls, 0 places");
  EXPECT_EQ(pipeline.note(7).kind, StageNotes::Kind::kNone);
}

TEST_F(StageTable, ChecksPartsOfLibrariesAsItsOwn) {
  try {
    read_config(with_stack({"tell_balls"}));
    FAIL() << "a part that nobody wrote";
  } catch (const SettingsError& error) {
    EXPECT_STREQ(
        error.what(),
        "/cameras/0/stack/0: stage 'tell_balls' needs 'ball_count', which no earlier stage provides");
  }
}

TEST_F(StageTable, OffersTheirParametersAsItsOwn) {
  const Json camera = settings_schema()["properties"]["cameras"]["items"]["properties"];
  EXPECT_THAT(camera["stack"]["items"]["enum"], testing::Contains("count_balls"));
  EXPECT_EQ(camera["stages"]["properties"]["count_balls"]["properties"]["at_least"]["x-unit"], "balls");
  EXPECT_EQ(camera["stages"]["properties"]["count_balls"]["description"], "counts the balls");
  const Json tree = complete_settings(with_stack({"segment"}));
  EXPECT_EQ(tree["cameras"][0]["stages"]["count_balls"]["at_least"], 0);
}

TEST_F(StageTable, DropsAMissingStageAndItsDependents) {
  const Json settings =
      with_stack({"gone", "find_runs", "find_regions", "publish"}, {{"gone", {{"level", 3}}}});
  const Config config = read_config(settings);
  EXPECT_THAT(config.cameras[0].running.stages, IsEmpty());
  EXPECT_THAT(config.cameras[0].running.missing, ElementsAre("gone"));
  EXPECT_THAT(config.cameras[0].running.idle, ElementsAre("find_runs", "find_regions", "publish"));
  EXPECT_EQ(missing_text(config.cameras[0].running),
            "without the stage 'gone', which is not installed; 'find_runs', 'find_regions' and 'publish' "
            "depend on a stage that does not run, and do not run either");
  EXPECT_THAT(missing_fix(config.cameras[0].running),
              HasSubstr("taken_name.so has a stage 'threshold', but another stage"));
  const Json tree = complete_settings(settings);
  EXPECT_EQ(tree["cameras"][0]["stack"], settings["cameras"][0]["stack"]) << "no setting is lost";
  EXPECT_EQ(tree["cameras"][0]["stages"]["gone"]["level"], 3);
}

TEST_F(StageTable, GoesOnWithTheRestOfAStack) {
  const Config config =
      read_config(with_stack({"segment", "detect_robots", "gone", "detect_balls", "publish"}));
  EXPECT_THAT(config.cameras[0].running.stages,
              ElementsAre("segment", "detect_robots", "detect_balls", "publish"));
  EXPECT_EQ(missing_text(config.cameras[0].running), "without the stage 'gone', which is not installed");
  EXPECT_THROW(read_config(with_stack({"detect_robots", "gone", "publish"})), SettingsError)
      << "what could never run is no matter of a missing stage";
}

TEST_F(StageTable, LeavesOutAStageThatDoesNotKnowItsParameters) {
  const Json settings = with_stack({"segment", "detect_robots", "detect_balls", "count_balls", "publish"},
                                   {{"count_balls", {{"of_another_version", 2}}}});
  const Config config = read_config(settings);
  EXPECT_THAT(config.cameras[0].running.stages,
              ElementsAre("segment", "detect_robots", "detect_balls", "publish"));
  EXPECT_THAT(
      missing_text(config.cameras[0].running),
      testing::AllOf(HasSubstr("without the stage 'count_balls', whose parameters are for another version"),
                     HasSubstr("/cameras/0/stages/count_balls/of_another_version")));
  EXPECT_EQ(complete_settings(settings)["cameras"][0]["stages"]["count_balls"]["of_another_version"], 2);
  EXPECT_NO_THROW(refuse_new_missing(config, config));
  EXPECT_THROW(refuse_new_missing(read_config(with_stack({"segment"})), config), SettingsError)
      << "from the network it is a mistake";
  EXPECT_THROW(read_config(with_stack({"segment"}, {{"segment", {{"of_another_version", 2}}}})),
               SettingsError)
      << "the service's own stages know theirs";
}

TEST_F(StageTable, RefusesNewMissingStagesOverTheNetwork) {
  const Config without = read_config(with_stack({"segment"})),
               with = read_config(with_stack({"segment", "gone"}));
  EXPECT_NO_THROW(refuse_new_missing(with, with));
  EXPECT_NO_THROW(refuse_new_missing(with, without));
  EXPECT_THROW(refuse_new_missing(without, with), SettingsError);
}

TEST_F(StageTable, AllocatesNothingForAnImage) {
  if (!counts_allocations()) GTEST_SKIP() << "the sanitizer has its own allocator";
  Pipeline pipeline(stage_table(),
                    {"threshold", "find_runs", "find_regions", "detect_robots", "detect_balls", "count_balls",
                     "tell_balls"},
                    "");
  const auto parameters = pipeline.make_parameters(Json::object(), "");
  Frame frame;
  const CameraContext context{std::make_shared<Scene>(), std::make_shared<Lut>(), std::make_shared<Mask>(),
                              std::make_shared<PatternTable>()};
  NoSink sink;
  for (int i = 0; i < 3; ++i) pipeline.run({frame, context, sink}, parameters);
  const std::uint64_t before = allocation_count();
  for (int i = 0; i < 100; ++i) pipeline.run({frame, context, sink}, parameters);
  EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace sslv::stage_table_test
