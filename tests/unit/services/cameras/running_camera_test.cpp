// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/running_camera.h"

#include "base/json.h"
#include "base/open_file.h"
#include "capture/controls.h"
#include "capture/shared_camera.h"
#include "capture/source.h"
#include "clips/clip_format.h"
#include "clips/image_ring.h"
#include "config/backends.h"
#include "support/becomes.h"
#include "support/paths.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <latch>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::running_camera_test {
namespace {

Config config_with(Json changes) {
  Json settings{{"cameras", {{{"id", 3}}}}};
  settings.update(changes);
  return read_config(settings);
}

/// A camera that is never started, to test how changes of settings affect its setup.
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

TEST_F(RunningCameraTest, ALightTableSetBetweenPlanAndApplyIsKept) {
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
                                      {"stack", {"threshold", "find_runs"}},
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
  EXPECT_EQ(change.setup->setup.pipeline->stack(), (std::vector<std::string>{"threshold", "find_runs"}));
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

/// A setup in a ring, as JSON; null if it is not there.
Json said_of(const ImageRing& ring, std::uint32_t number) {
  const std::vector<std::byte> payload = ring.setup(number);
  const auto parts = setup_in(payload);
  if (!parts) return nullptr;
  return Json::parse(std::string(reinterpret_cast<const char*>(parts->json.data()), parts->json.size()));
}

TEST_F(RunningCameraTest, ARingHasEachSetupAlsoAfterACrash) {
  const auto recorded = camera_.recorded();
  const std::uint32_t first = context_number();
  auto ring = std::make_shared<ImageRing>(std::size_t{1} << 20U);
  OpenFile file(::fcntl(ring->fd(), F_DUPFD_CLOEXEC, 0));
  recorded->keep({.ring = ring});
  auto change = get_ready(config_with({{"field", {{"field_length", 4321}}}}));
  camera_.apply(change, {140, 150});
  const std::uint32_t second = context_number();
  const auto accepted = context().accepted_lut;
  ASSERT_TRUE(camera_.change_light(accepted, std::make_shared<const Lut>(*accepted)));
  const std::uint32_t third = context_number();
  const ImageRing left(std::move(file));
  const Json before = said_of(left, first), now = said_of(left, second);
  ASSERT_TRUE(before.is_object()) << "it was there before the ring";
  ASSERT_TRUE(now.is_object());
  EXPECT_EQ(now["settings"]["cameras"][0]["id"], 3);
  EXPECT_EQ(now["settings"]["field"]["field_length"], 4321);
  EXPECT_NE(before["settings"]["field"]["field_length"], 4321);
  EXPECT_EQ(said_of(left, third)["settings"], now["settings"]) << "the light is no change of settings";
}

TEST_F(RunningCameraTest, ARingKeepsTheSetupThatIsInUse) {
  const auto recorded = camera_.recorded();
  const std::uint32_t first = context_number();
  auto ring = std::make_shared<ImageRing>(std::size_t{1} << 20U);
  recorded->keep({.ring = ring});
  auto change = get_ready(config_with({{"field", {{"field_length", 4321}}}}));
  camera_.apply(change, {140, 150});
  recorded->forget_before(context_number());
  EXPECT_TRUE(said_of(*ring, first).is_null());
  recorded->forget_before(1000);
  EXPECT_TRUE(said_of(*ring, context_number()).is_object()) << "it is in use";
}

Config config_of_tile(const Json& controls) {
  return config_with(
      {{"cameras",
        {{{"id", 3},
          {"stack", {"segment"}},
          {"source",
           {{"backend", "tile"},
            {"of",
             {{"backend", "files"}, {"path", source_path("/tests/golden/division_b.jpg")}, {"loop", true}}},
            {"width", 64},
            {"height", 64},
            {"controls", controls}}}}}}});
}

/// Blocks in controls(), which is part of opening a camera, until the test releases it.
struct HeldCamera final : Source {
  struct Hold {
    std::atomic<bool> is_asked{false};
    std::latch let_go{1};
  };
  HeldCamera(std::unique_ptr<Source> of, std::shared_ptr<Hold> by)
      : camera(std::move(of)), hold(std::move(by)) {}

  CaptureStatus next(CapturedImage& image, std::string& problem, std::chrono::milliseconds timeout) override {
    return camera->next(image, problem, timeout);
  }
  std::shared_ptr<Controls> controls() override {
    hold->is_asked = true;
    hold->let_go.wait();
    return camera->controls();
  }

  const std::unique_ptr<Source> camera;
  const std::shared_ptr<Hold> hold;
};

TEST_F(RunningCameraTest, ControlsSavedDuringOpeningAreSet) {
  const Config before = config_of_tile(Json::object()), after = config_of_tile({{"speed", 2.0}});
  const Json of = before.cameras[0].source.at("of");
  const auto hold = std::make_shared<HeldCamera::Hold>();
  const auto shared = SharedCamera::get(of.dump(), [&] {
    return std::make_unique<HeldCamera>(open_source(of, {3, Scene()}), hold);
  });
  RunningCamera camera(before.cameras[0], first_setup(before), std::make_shared<const Config>(before),
                       multicast_, intake_.add(), std::make_shared<CameraTotals>());
  auto change = camera.plan(after.cameras[0], std::make_shared<const Config>(after), std::nullopt,
                            "/cameras/0/source/controls");
  camera.get_ready(change);
  camera.start();
  ASSERT_TRUE(test::becomes([&] { return hold->is_asked.load(); }));
  EXPECT_FALSE(camera.apply(change, {140, 150})) << "it need not be opened again";
  EXPECT_THAT(camera.outcome(change), testing::IsEmpty());
  EXPECT_EQ(camera.controls(), nullptr) << "it is still being opened";
  hold->let_go.count_down();
  EXPECT_TRUE(test::becomes([&] {
    const auto controls = camera.controls();
    return controls != nullptr && controls->get("speed").value == 2;
  }));
}

TEST_F(RunningCameraTest, ControlsPlannedBeforeOpeningAreSet) {
  const Config before = config_of_tile(Json::object()), after = config_of_tile({{"speed", 2.0}});
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

TEST_F(RunningCameraTest, UsesTheRobotHeightsAtTheTimeOfApplying) {
  auto change = get_ready(config_with({{"field", {{"field_length", 4321}}}}));
  camera_.change_robot_heights({141, 142});
  camera_.apply(change, {143, 144});
  EXPECT_THAT(context().scene->robot_height_mm, testing::ElementsAre(143, 144));
}

}  // namespace
}  // namespace sslv::running_camera_test
