// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::camera_setup_test {
namespace {

class CameraSetups : public testing::Test {
 protected:
  static Config config_with(const Json& changes) {
    Json settings{{"cameras", {{{"id", 3}}}}};
    settings.update(changes);
    return read_config(settings);
  }
  static Config camera_with(Json changes) {
    Json camera{{"id", 3}};
    camera.update(changes);
    return config_with({{"cameras", {camera}}});
  }
  std::optional<NewSetup> after(const Config& next) const {
    return plan_setup(next, 0, CameraInUse{now_, now_.cameras[0], setup_}, {});
  }
  static CameraSetup first(const Config& config) {
    NewSetup out = *plan_setup(config, 0, std::nullopt, {});
    EXPECT_EQ(out.setup.pipeline, nullptr) << "only planned";
    out.make_stages(config.cameras[0]);
    return std::move(out.setup);
  }

  const Config now_ = config_with(Json::object());
  const CameraSetup setup_ = first(now_);
};

TEST_F(CameraSetups, ReuseTheParametersReadWithTheSettings) {
  ASSERT_EQ(setup_.parameters.size(), now_.cameras[0].stack.size());
  for (std::size_t i = 0; i < setup_.parameters.size(); ++i) {
    EXPECT_THAT(now_.cameras[0].stage_params, testing::Contains(setup_.parameters[i])) << "not read again";
  }
}

TEST_F(CameraSetups, AreKeptForUnrelatedChanges) {
  EXPECT_FALSE(after(config_with({{"site", "elsewhere"}})));
  EXPECT_FALSE(after(config_with({{"network", {{"vision", {{"ttl", 3}}}}}})));
  EXPECT_FALSE(after(camera_with({{"name", "north"}})));
  EXPECT_FALSE(after(camera_with({{"thread", {{"cpu", 1}}}})));
  EXPECT_FALSE(after(camera_with({{"follow_light", {{"enabled", true}}}})));
}

TEST_F(CameraSetups, AreMadeForRelatedChanges) {
  EXPECT_TRUE(after(config_with({{"field", {{"field_length", 4321}}}})));
  EXPECT_TRUE(after(config_with({{"teams", {{"blue", {{"robot_height", 150}}}}}})));
  EXPECT_TRUE(after(camera_with({{"stages", {{"detect_balls", {{"max_balls", 5}}}}}})));
  EXPECT_TRUE(after(camera_with({{"colors", {{"bits", 6}}}})));
  const auto other_stack = after(camera_with(
      {{"stack", {"threshold", "find_runs", "find_regions", "detect_robots", "detect_balls", "publish"}}}));
  ASSERT_TRUE(other_stack);
  EXPECT_NE(other_stack->setup.pipeline, setup_.pipeline);
}

TEST_F(CameraSetups, KeepPipelineAndColoursIfPossible) {
  const auto next = after(config_with({{"field", {{"field_length", 4321}}}}));
  ASSERT_TRUE(next);
  EXPECT_EQ(next->setup.pipeline, setup_.pipeline);
  EXPECT_TRUE(next->keeps_colors);
  EXPECT_EQ(next->setup.context.accepted_lut, setup_.context.accepted_lut);
  EXPECT_FALSE(after(camera_with({{"colors", {{"bits", 6}}}}))->keeps_colors);
}

}  // namespace
}  // namespace sslv::camera_setup_test
