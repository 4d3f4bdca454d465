// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/running_camera.h"

#include "base/open_file.h"
#include "clips/image_ring.h"
#include "clips/left_ring.h"
#include "support/becomes.h"
#include "support/paths.h"

#include <memory>
#include <utility>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv {
namespace {

Config config_with(Json changes) {
  Json settings{{"cameras", {{{"id", 3}}}}};
  settings.update(changes);
  return read_config(settings);
}

/// A camera that is never started: what a change of settings makes of its setup.
class RunningCameraTest : public testing::Test {
 protected:
  RunningCamera::Change get_ready(const Config& next) {
    const CameraSetup& setup = *camera_.pipeline().setup();
    auto change =
        camera_.plan(next.cameras[0], std::make_shared<const Config>(next),
                     plan_setup(next, 0, CameraInUse{now_, now_.cameras[0], setup}, {}), "/cameras/0");
    camera_.get_ready(change);
    return change;
  }
  static CameraSetup first_setup(const Config& config) {
    NewSetup out = *plan_setup(config, 0, std::nullopt, {});
    out.make_stages(config.cameras[0]);
    return std::move(out.setup);
  }
  CameraContext context() const { return camera_.pipeline().setup()->context; }
  std::uint32_t context_number() const { return camera_.pipeline().setup()->number; }

  const Config now_ = config_with(Json::object());
  MulticastSender multicast_{MulticastSettings{}};
  FieldIntake intake_;
  RunningCamera camera_{now_.cameras[0], first_setup(now_), std::make_shared<const Config>(now_),
                        multicast_,      intake_.add(),     std::make_shared<CameraTotals>()};
};

TEST_F(RunningCameraTest, ALightTableOfTheTimeBetweenPlanAndApplyIsKept) {
  const auto accepted = context().accepted_lut;
  auto change = get_ready(config_with({{"field", {{"field_length", 4321}}}}));
  ASSERT_TRUE(change.setup);
  const auto adapted = std::make_shared<const Lut>(*accepted);
  ASSERT_TRUE(camera_.change_light(accepted, adapted));
  camera_.apply(change, {140, 150});
  EXPECT_EQ(context().scene->field.field_length, 4321);
  EXPECT_EQ(context().adapted_lut, adapted);
  EXPECT_EQ(context().accepted_lut, accepted);
}

TEST_F(RunningCameraTest, APlanMakesNoStageAndNoThread) {
  const Config next = config_with({{"cameras",
                                    {{{"id", 3},
                                      {"stack", {"segment", "publish"}},
                                      {"thread", {{"cpu", 0}}},
                                      {"source", {{"backend", "simulator"}, {"width", 320}}}}}}});
  const CameraSetup& setup = *camera_.pipeline().setup();
  auto change =
      camera_.plan(next.cameras[0], std::make_shared<const Config>(next),
                   plan_setup(next, 0, CameraInUse{now_, now_.cameras[0], setup}, {}), "/cameras/0");
  EXPECT_TRUE(change.reopens);
  EXPECT_EQ(change.thread, nullptr);
  ASSERT_TRUE(change.setup);
  EXPECT_EQ(change.setup->setup.pipeline, nullptr);
  camera_.get_ready(change);
  EXPECT_NE(change.thread, nullptr);
  EXPECT_EQ(change.setup->setup.pipeline->stack(), (std::vector<std::string>{"segment", "publish"}));
}

TEST_F(RunningCameraTest, OtherColoursEndTheLightTableOfTheEarlierOnes) {
  const auto accepted = context().accepted_lut;
  auto change = get_ready(config_with({{"cameras", {{{"id", 3}, {"colors", {{"bits", 6}}}}}}}));
  ASSERT_TRUE(change.setup);
  const auto adapted = std::make_shared<const Lut>(*accepted);
  ASSERT_TRUE(camera_.change_light(accepted, adapted));
  camera_.apply(change, {140, 150});
  EXPECT_NE(context().accepted_lut, accepted);
  EXPECT_EQ(context().adapted_lut, context().accepted_lut);
  EXPECT_FALSE(camera_.change_light(accepted, adapted)) << "it was made for the earlier colours";
}

TEST_F(RunningCameraTest, ARecordingKnowsWhatEachSetupIs) {
  const auto recorded = camera_.recorded();
  ASSERT_TRUE(recorded->setup(context_number()));
  EXPECT_EQ(recorded->setup(context_number())->config->cameras[0].id, 3);
  auto change = get_ready(config_with({{"field", {{"field_length", 4321}}}}));
  camera_.apply(change, {140, 150});
  const auto second = recorded->setup(context_number());
  ASSERT_TRUE(second);
  EXPECT_EQ(second->config->field.field_length, 4321);
  EXPECT_EQ(second->setup->context.scene, context().scene);
  const auto accepted = context().accepted_lut;
  ASSERT_TRUE(camera_.change_light(accepted, std::make_shared<const Lut>(*accepted)));
  const auto third = recorded->setup(context_number());
  ASSERT_TRUE(third);
  EXPECT_EQ(third->config, second->config) << "the light is no change of settings";
  EXPECT_EQ(third->setup->context.adapted_lut, context().adapted_lut);
  recorded->forget_before(third->setup->number);
  EXPECT_FALSE(recorded->setup(second->setup->number));
  recorded->forget_before(1000);
  EXPECT_TRUE(recorded->setup(third->setup->number)) << "it is in use";
}

TEST_F(RunningCameraTest, ARingHasTheSetupsForWhoFindsItAfterACrash) {
  const auto recorded = camera_.recorded();
  const std::uint32_t first = context_number();
  auto ring = std::make_shared<ImageRing>(std::size_t{1} << 20U);
  OpenFile file(::fcntl(ring->fd(), F_DUPFD_CLOEXEC, 0));
  recorded->keep({.ring = ring});
  auto change = get_ready(config_with({{"field", {{"field_length", 4321}}}}));
  camera_.apply(change, {140, 150});
  const auto expected = recorded->setup_for_clip(context_number());
  ASSERT_TRUE(expected);
  const LeftRing left(std::move(file));
  const auto before = left.setup(first), now = left.setup(context_number());
  ASSERT_TRUE(before) << "it was there before the ring";
  ASSERT_TRUE(now);
  EXPECT_EQ(now->camera_id, 3);
  EXPECT_EQ(now->about["settings"]["field"]["field_length"], 4321);
  EXPECT_NE(before->about["settings"]["field"]["field_length"], 4321);
  EXPECT_EQ(now->about, expected->about);
  EXPECT_EQ(now->table, expected->table);
}

TEST_F(RunningCameraTest, ControlsThatAreSavedWhileItIsOpenedAreSetAllTheSame) {
  const auto with = [](const Json& controls) {
    return config_with({{"cameras",
                         {{{"id", 3},
                           {"stack", {"segment"}},
                           {"source",
                            {{"backend", "files"},
                             {"path", source_path("/tests/golden/division_b.jpg")},
                             {"loop", true},
                             {"controls", controls}}}}}}});
  };
  const Config before = with(Json::object()), after = with({{"speed", 2.0}});
  RunningCamera camera(before.cameras[0], first_setup(before), std::make_shared<const Config>(before),
                       multicast_, intake_.add(), std::make_shared<CameraTotals>());
  auto change = camera.plan(after.cameras[0], std::make_shared<const Config>(after), std::nullopt,
                            "/cameras/0/source/controls");
  camera.get_ready(change);
  camera.start();
  ASSERT_TRUE(test::becomes([&] { return camera.controls() != nullptr; }));
  EXPECT_FALSE(camera.apply(change, {140, 150})) << "it need not be opened again";
  EXPECT_THAT(camera.outcome(change), testing::IsEmpty());
  EXPECT_EQ(camera.controls()->get("speed").value, 2);
}

TEST_F(RunningCameraTest, RobotHeightsAreThoseOfWhenItIsApplied) {
  auto change = get_ready(config_with({{"field", {{"field_length", 4321}}}}));
  camera_.change_robot_heights({141, 142});
  camera_.apply(change, {143, 144});
  EXPECT_THAT(context().scene->robot_height_mm, testing::ElementsAre(143, 144));
}

}  // namespace
}  // namespace sslv
