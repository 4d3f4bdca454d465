// SPDX-License-Identifier: Apache-2.0
#include "vision/field_view.h"

#include "base/params_json.h"
#include "config/config.h"
#include "support/drawn_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>

namespace sslv::field_view_test {
namespace {

using Interval = Mask::Interval;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// A narrow field below the cameras.
Scene small_field(const CameraCalibration& calibration) {
  Scene scene;
  scene.field.field_length = 4500;
  scene.field.field_width = 1000;
  scene.field.boundary_width = scene.field.boundary_width_goal_line = 100;
  scene.camera.emplace(calibration);
  return scene;
}

int distance_outside_mm(const Scene& scene, Eigen::Vector2d place_mm) {
  const double x = std::abs(place_mm.x()) - scene.field.field_length / 2.0 - 100,
               y = std::abs(place_mm.y()) - scene.field.field_width / 2.0 - 100;
  return static_cast<int>(std::max(x, y));
}

TEST(FieldView, ShowsTheFieldWithAMarginAndHidesTheHall) {
  for (const CameraCalibration& calibration : {overhead_camera(), oblique_camera()}) {
    const Scene scene = small_field(calibration);
    const Mask mask({}, field_view(scene, 200));
    int shown = 0, hidden = 0;
    for (int y = 0; y < 580; y += 3) {
      for (int x = 0; x < 780; x += 3) {
        const auto ground_mm = scene.camera->unproject({x, y}, 0),
                   top_mm = scene.camera->unproject({x, y}, 150);
        const int ground = ground_mm ? distance_outside_mm(scene, *ground_mm) : 100'000;
        const int top = top_mm ? distance_outside_mm(scene, *top_mm) : 100'000;
        const bool shows = mask.shows(x, y);
        if (ground <= 200 || top <= 200) {
          ASSERT_TRUE(shows) << x << ' ' << y;
        }
        // Blocks of the grid are up to 16 px wide, and a pixel is up to 12 mm in the oblique image, so up to
        // 250 mm more may be shown.
        if (ground > 200 + 250 && top > 200 + 250) {
          ASSERT_FALSE(shows) << x << ' ' << y;
        }
        ++(shows ? shown : hidden);
      }
    }
    EXPECT_GT(shown, 10'000);
    EXPECT_GT(hidden, 10'000);
  }
}

TEST(FieldView, HidesWhatLiesAboveTheHorizon) {
  CameraCalibration level = oblique_camera();  // looks along the floor, to the horizon
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond q = turn * Eigen::Quaterniond(overhead_camera().q3, overhead_camera().q0,
                                                         overhead_camera().q1, overhead_camera().q2);
  const Eigen::Vector3d t = -(q * Eigen::Vector3d(0, -3000, 1500));
  level.q0 = q.x(), level.q1 = q.y(), level.q2 = q.z(), level.q3 = q.w();
  level.tx = t.x(), level.ty = t.y(), level.tz = t.z();
  const Scene scene = small_field(level);
  const Mask mask({}, field_view(scene, 200));
  int beyond = 0;
  for (int y = 0; y < 580; y += 20) {
    for (int x = 0; x < 780; x += 20) {
      if (scene.camera->unproject({x, y}, 0) || scene.camera->unproject({x, y}, 150)) continue;
      ++beyond;
      EXPECT_FALSE(mask.shows(x, y)) << x << ' ' << y;
    }
  }
  EXPECT_GT(beyond, 100);
}

TEST(FieldView, LimitsTheMaskInPixelsAndQuads) {
  FieldView view;
  view.width_px = 96;
  view.bands = {{{16, 48}, {64, 80}}, {}};
  const Mask mask({{{{{-1, -1}, {40.5, -1}, {40.5, 99}, {-1, 99}}}}, {}}, view);
  EXPECT_THAT(mask.row(0, 1), ElementsAre(Interval{16, 41}));
  EXPECT_THAT(mask.row(15, 1), ElementsAre(Interval{16, 41}));
  EXPECT_THAT(mask.row(16, 1), IsEmpty());
  EXPECT_THAT(mask.row(7, 2), ElementsAre(Interval{8, 20}));
  EXPECT_THAT(mask.row(8, 2), IsEmpty());
  // Outside the image for which the camera was calibrated, everything is shown.
  const Mask whole({}, view);
  EXPECT_THAT(whole.row(0, 1), ElementsAre(Interval{16, 48}, Interval{64, 80}, Interval{96, 16'384}));
  EXPECT_THAT(whole.row(20, 2), ElementsAre(Interval{0, 16'384}));
}

TEST(FieldView, HiddenRectanglesCoverTheRest) {
  FieldView view;
  view.width_px = 64;
  view.bands = {{{16, 48}}, {{16, 48}}, {}, {{0, 64}}, {{32, 64}}};
  std::vector<std::array<int, 4>> found;
  for (const PixelRectangle& one : hidden_by(view))
    found.push_back({one.left_px, one.top_px, one.width_px, one.height_px});
  EXPECT_THAT(found, ElementsAre(std::array{0, 0, 16, 32}, std::array{48, 0, 16, 32},
                                 std::array{0, 32, 64, 16}, std::array{0, 64, 32, 16}));
}

TEST(FieldView, LimitsTheStagesUnlessTheSettingsSayTheWholeImage) {
  Json camera = {{"calibration", params_to_json(overhead_camera())}};
  const auto context_of = [&] {
    return make_context(
        read_config({{"field", {{"field_length", 4500}, {"field_width", 1000}}}, {"cameras", {camera}}}), 0,
        std::make_shared<const Lut>());
  };
  const CameraContext limited = context_of();
  EXPECT_FALSE(limited.looked_at().shows(300, 5));
  EXPECT_TRUE(limited.looked_at().shows(300, 290));
  EXPECT_TRUE(limited.mask->shows(300, 5)) << "learning and exposure may look there";
  camera["mask"]["beyond_boundary"] = 2000;
  EXPECT_TRUE(context_of().looked_at().shows(300, 5));
  camera["mask"]["beyond_boundary"] = nullptr;
  EXPECT_FALSE(context_of().field_view);
  EXPECT_TRUE(context_of().looked_at().shows(0, 0));
  camera["calibration"] = nullptr;
  camera["mask"]["beyond_boundary"] = 0;
  EXPECT_TRUE(context_of().looked_at().shows(300, 5)) << "nobody knows where the field is";
}

}  // namespace
}  // namespace sslv::field_view_test
