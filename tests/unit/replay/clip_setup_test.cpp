// SPDX-License-Identifier: Apache-2.0
#include "replay/clip_setup.h"

#include "base/params_json.h"
#include "colors/table_in_light.h"
#include "support/live_run.h"
#include "support/temporary_folder.h"
#include "vision/patterns_text.h"

#include <gmock/gmock.h>

namespace sslv::clip_setup_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using testing::ThrowsMessage;

constexpr const char* kPatterns = R"({"name": "lab", "center_diameter_mm": 30.5, "dot_diameter_mm": 20,
    "dots": [[40, 0], [-40, 0.1, 21]], "team_colors": {"yellow": "purple", "blue": "blue"},
    "codes": [{"id": 1, "colors": ["pink", "cyan"]}, {"id": 7, "colors": ["pink", "purple"]}]})";

void expect_same(const LutTable& a, const LutTable& b) {
  EXPECT_EQ(a.bits, b.bits);
  EXPECT_TRUE(a.labels == b.labels);
  EXPECT_TRUE(a.blocks == b.blocks);
  EXPECT_TRUE(a.chroma == b.chroma);
}

void expect_same(const Mask& a, const Mask& b) {
  for (int y = 0; y < 700; ++y) {
    EXPECT_TRUE(std::ranges::equal(a.row(y, 1), b.row(y, 1))) << y;
    EXPECT_TRUE(std::ranges::equal(a.row(y, 2), b.row(y, 2))) << y;
  }
}

/// Compares everything that stages get.
void expect_same(const CameraSetup& a, const CameraSetup& b) {
  EXPECT_EQ(a.pipeline->stack(), b.pipeline->stack());
  const CameraContext &one = a.context, &other = b.context;
  expect_same(one.adapted_lut->yuv(), other.adapted_lut->yuv());
  expect_same(one.adapted_lut->rgb(), other.adapted_lut->rgb());
  EXPECT_EQ(one.adapted_lut->color_bits(), other.adapted_lut->color_bits());
  EXPECT_EQ(one.adapted_lut->prints(), other.adapted_lut->prints());
  for (std::size_t i = 0; i < label::kMaxCount; ++i) {
    const auto value = static_cast<Label>(i);
    EXPECT_EQ(one.adapted_lut->chromaticity_mean(value), other.adapted_lut->chromaticity_mean(value));
    EXPECT_EQ(one.adapted_lut->chromaticity_spread(value), other.adapted_lut->chromaticity_spread(value));
  }
  expect_same(*one.mask, *other.mask);
  expect_same(one.looked_at(), other.looked_at());
  EXPECT_EQ(params_to_json(one.scene->field), params_to_json(other.scene->field));
  EXPECT_EQ(one.scene->robot_height_mm, other.scene->robot_height_mm);
  EXPECT_EQ(one.scene->roster, other.scene->roster);
  ASSERT_EQ(one.scene->camera.has_value(), other.scene->camera.has_value());
  if (one.scene->camera) {
    EXPECT_EQ(params_to_json(one.scene->camera->calibration()),
              params_to_json(other.scene->camera->calibration()));
    EXPECT_EQ(one.scene->camera->position_mm(), other.scene->camera->position_mm());
  }
  EXPECT_EQ(patterns_text(*one.patterns, *one.labels), patterns_text(*other.patterns, *other.labels));
  EXPECT_EQ(one.patterns->reach_mm, other.patterns->reach_mm);
  EXPECT_EQ(one.patterns->gap_mm, other.patterns->gap_mm);
  EXPECT_EQ(one.patterns->rings.size(), other.patterns->rings.size());
}

CameraSetup setup_in(const Config& config, std::size_t i) {
  const CameraSettings& camera = config.cameras[i];
  CameraSetup setup;
  setup.pipeline = std::make_shared<Pipeline>(stage_table(), camera.running.stages, "/stack");
  setup.parameters = setup.pipeline->parameters_of(camera.stage_params);
  setup.context = make_context(config, i);
  return setup;
}

TEST(ClipSetups, GiveTheSameBack) {
  const Config config = read_config(live_settings());
  for (std::size_t i = 0; i < 2; ++i) {
    const CameraSetup live = setup_in(config, i);
    const ClipSetup clip = clip_setup(config, i, live);
    EXPECT_EQ(clip.camera_id, config.cameras[i].id);
    EXPECT_EQ(clip.about["settings"]["cameras"].size(), 1u);
    EXPECT_TRUE(clip.about["patterns"].is_null());
    expect_same(live, setup_of(clip, nullptr, "clip"));
  }
}

TEST(ClipSetups, KeepAllThatIsNotInTheSettings) {
  const test::TemporaryFolder folder;
  Json settings = live_settings();
  settings["own_labels"] = {{{"value", 12}, {"name", "purple"}}};
  settings["patterns_file"] = folder.write("lab.json", kPatterns);
  settings["teams"]["blue"]["ids"] = {1, 7};
  Json& camera = settings["cameras"][1];
  camera["colors"]["bits"] = 6;
  camera["mask"] = {{"exclude", {{{"points", {{10, 10}, {100, 20}, {50, 200}}}}}}, {"beyond_boundary", 40}};
  camera["stack"] = {"threshold", "find_runs", "find_regions", "detect_robots", "detect_balls", "publish"};
  const Config config = read_config(settings);
  CameraSetup live = setup_in(config, 1);
  Scene scene = *live.context.scene;
  scene.robot_height_mm = {151.25, 99.5};
  live.context.scene = std::make_shared<const Scene>(scene);
  live.context.adapted_lut = std::make_shared<const Lut>(
      table_in_light(*live.context.accepted_lut, {.gain = {0.8, 0.85, 0.7}, .darkest_area = 0.9}));
  const ClipSetup clip = clip_setup(config, 1, live);
  std::filesystem::remove(folder.file("lab.json"));
  expect_same(live, setup_of(clip, nullptr, "clip"));
}

TEST(ClipSetups, KeepThePipelineOfTheSameStack) {
  const Config config = read_config(live_settings());
  const CameraSetup live = setup_in(config, 0);
  const ClipSetup clip = clip_setup(config, 0, live);
  const CameraSetup first = setup_of(clip, nullptr, "clip");
  EXPECT_EQ(setup_of(clip, first.pipeline, "clip").pipeline, first.pipeline);
  Json other = live_settings();
  other["cameras"][0]["stack"] = {"segment", "detect_robots", "detect_balls"};
  const Config changed = read_config(other);
  EXPECT_NE(setup_of(clip_setup(changed, 0, setup_in(changed, 0)), first.pipeline, "clip").pipeline,
            first.pipeline);
}

TEST(ClipSetups, DoNotNeedTheCamerasBackend) {
  const Config config = read_config(live_settings());
  ClipSetup clip = clip_setup(config, 0, setup_in(config, 0));
  clip.about["settings"]["cameras"][0]["source"] = {{"backend", "of another build"}};
  EXPECT_NO_THROW(setup_of(clip, nullptr, "clip"));
}

TEST(ClipSetups, SayInOneLineWhatIsWrong) {
  const Config config = read_config(live_settings());
  const ClipSetup good = clip_setup(config, 0, setup_in(config, 0));
  const auto error_of = [&](const auto& spoil) {
    ClipSetup clip = good;
    spoil(clip);
    return [clip] { setup_of(clip, nullptr, "a.clip, setup 0"); };
  };
  const auto says = [](const char* what) {
    return ThrowsMessage<SettingsError>(AllOf(StartsWith("a.clip, setup 0: "), HasSubstr(what)));
  };
  EXPECT_THAT(error_of([](ClipSetup& clip) { clip.about = Json::array(); }), says("/settings: is missing"));
  EXPECT_THAT(error_of([](ClipSetup& clip) { clip.about["settings"]["site"] = 7; }), says("/site"));
  EXPECT_THAT(error_of([](ClipSetup& clip) { clip.about["settings"]["cameras"] = Json::array(); }),
              says("expected camera 0 alone"));
  EXPECT_THAT(error_of([](ClipSetup& clip) { clip.camera_id = 5; }), says("expected camera 5 alone"));
  EXPECT_THAT(error_of([](ClipSetup& clip) { clip.about.erase("robot_height_mm"); }),
              says("/robot_height_mm: is missing"));
  EXPECT_THAT(error_of([](ClipSetup& clip) {
                clip.about["robot_height_mm"] = {140, "x"};
              }),
              says("/robot_height_mm/1"));
  EXPECT_THAT(error_of([](ClipSetup& clip) { clip.about["patterns"] = 3; }), says("/patterns"));
  EXPECT_THAT(error_of([](ClipSetup& clip) { clip.about["patterns"] = "{"; }), says("/patterns"));
  EXPECT_THAT(error_of([](ClipSetup& clip) { clip.table.resize(40); }), says("/table"));
  EXPECT_THAT(
      error_of([](ClipSetup& clip) { clip.about["settings"]["cameras"][0]["stack"] = {"of a library"}; }),
      says("unknown stage 'of a library'"));
}

TEST(OtherSetups, KeepTheClipsTableWhereColoursAreTheSame) {
  const Config config = read_config(live_settings());
  CameraSetup live = setup_in(config, 0);
  live.context.adapted_lut =
      std::make_shared<const Lut>(table_in_light(*live.context.accepted_lut, {.gain = {0.7, 0.7, 0.7}}));
  const ClipSetup clip = clip_setup(config, 0, live);
  Json settings = live_settings();
  settings["cameras"][0]["stages"]["detect_balls"]["max_balls"] = 2;
  OtherSetup other{std::make_shared<const Config>(read_config(settings)), "new.json"};
  expect_same(live.context.adapted_lut->yuv(),
              setup_with(other, clip, nullptr, "clip").context.adapted_lut->yuv());
  settings["cameras"][0]["colors"]["classes"][0]["luma"] = {0, 10};
  other.settings = std::make_shared<const Config>(read_config(settings));
  EXPECT_FALSE(live.context.adapted_lut->yuv().labels ==
               setup_with(other, clip, nullptr, "clip").context.adapted_lut->yuv().labels);
}

TEST(OtherSetups, KeepTheHeightFromTheGameController) {
  const Config config = read_config(live_settings());
  CameraSetup live = setup_in(config, 0);
  Scene scene = *live.context.scene;
  scene.robot_height_mm[1] = 133;
  live.context.scene = std::make_shared<const Scene>(scene);
  const ClipSetup clip = clip_setup(config, 0, live);
  Json settings = live_settings();
  settings["teams"] = {{"yellow", {{"robot_height", 120}}}, {"blue", {{"robot_height", 120}}}};
  OtherSetup other{std::make_shared<const Config>(read_config(settings)), "new.json"};
  EXPECT_THAT(setup_with(other, clip, nullptr, "clip").context.scene->robot_height_mm,
              testing::ElementsAre(120, 133));
  settings["teams"]["height_from_referee"] = false;
  other.settings = std::make_shared<const Config>(read_config(settings));
  EXPECT_THAT(setup_with(other, clip, nullptr, "clip").context.scene->robot_height_mm,
              testing::ElementsAre(120, 120));
  settings["cameras"].erase(0);
  other.settings = std::make_shared<const Config>(read_config(settings));
  EXPECT_THAT([&] { setup_with(other, clip, nullptr, "clip"); },
              ThrowsMessage<SettingsError>("new.json: has no camera 0, which the clip has"));
}

}  // namespace
}  // namespace sslv::clip_setup_test
