// SPDX-License-Identifier: Apache-2.0
#include "calibration/check_lines.h"

#include "calibration/publish.h"
#include "support/painted_floor.h"

#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace sslv::check_lines_test {
namespace {

constexpr double kWindowMm = 250;

/// Verdict on the lines of an image, for this calibration and these field sizes.
LinesVerdict looked_for(const FloorPicture& picture, const LensCamera& calibrated, const FieldSize& sizes) {
  const auto curves = painted_curves(sizes);
  return judge_lines(
      check_lines(picture.view, CameraModel(publish(calibrated).calibration), curves, kWindowMm));
}

struct Case {
  FloorSetting setting;
  PaintedFloor floor;
};

std::vector<Case> cases_of(FloorView view) {
  std::vector<Case> out;
  for (const int size : {0, 1}) {
    for (const double dim_to : {1.0, 0.5}) {
      Case one{{.size = size, .view = view}, {}};
      one.floor.field = floor_field(size);
      one.floor.dim_to = dim_to;
      one.floor.robots_on_lines = true;
      one.floor.wavy_mm = 3;
      one.floor.seed = static_cast<unsigned>(out.size() + 1);
      out.push_back(one);
    }
  }
  return out;
}

class CheckLinesOf : public ::testing::TestWithParam<FloorView> {};

// One test for both checks, since drawing takes most of the time.
TEST_P(CheckLinesOf, FindsThemAndMeasuresHowFarACameraMoved) {
  for (const Case& one : cases_of(GetParam())) {
    SCOPED_TRACE(fmt::format("size {}, dim to {}", one.setting.size, one.floor.dim_to));
    const LensCamera truth = floor_camera(one.setting);
    const FloorPicture picture = draw_floor(one.floor, truth);
    const LinesVerdict good = looked_for(picture, truth, one.floor.field);
    EXPECT_GE(good.lines, 3);
    EXPECT_LT(good.worst_mm, 15);
    EXPECT_LT(good.missing_share, 0.25);
    for (const double moved_mm : {40.0, 80.0, 150.0}) {
      LensCamera calibrated = truth;
      calibrated.position_mm += Eigen::Vector3d(moved_mm, 0, 0);
      EXPECT_NEAR(looked_for(picture, calibrated, one.floor.field).worst_mm, moved_mm, 15);
    }
  }
}

TEST(CheckLines, AreMissingForAnotherFieldSize) {
  for (const FloorView view : {FloorView::kWhole, FloorView::kHalf}) {
    PaintedFloor floor;
    floor.field = floor_field(1);
    const LensCamera camera = floor_camera({.size = 1, .view = view});
    FieldSize other = floor.field;
    other.field_length -= 1200;
    other.field_width -= 800;
    EXPECT_GT(looked_for(draw_floor(floor, camera), camera, other).missing_share, 0.4);
  }
}

class DivisionFrom : public ::testing::TestWithParam<FloorView> {};

TEST_P(DivisionFrom, TheLinesItSees) {
  const FieldSize& small = field_preset("division-b", "");
  const FieldSize& large = field_preset("division-a", "");
  for (const auto* painted : {&small, &large}) {
    PaintedFloor floor;
    floor.field = *painted;
    const LensCamera lens = floor_camera({.size = painted == &small ? 1 : 2, .view = GetParam()});
    const CameraModel camera(publish(lens).calibration);
    const FloorPicture picture = draw_floor(floor, lens);
    const auto better_than = [&](const FieldSize& told) {
      return find_better_size(picture.view, camera, told, looked_for(picture, lens, told), kWindowMm);
    };
    EXPECT_EQ(better_than(*painted), nullptr);
    const FieldPreset* better = better_than(painted == &small ? large : small);
    ASSERT_NE(better, nullptr) << (painted == &small ? "division B" : "division A");
    EXPECT_EQ(&better->size, painted);
  }
}

std::string name_of_view(const ::testing::TestParamInfo<FloorView>& view) {
  constexpr std::array<const char*, 3> kNames{"whole", "half", "quarter"};
  return kNames[static_cast<std::size_t>(view.param)];
}
INSTANTIATE_TEST_SUITE_P(Views, CheckLinesOf,
                         ::testing::Values(FloorView::kWhole, FloorView::kHalf, FloorView::kQuarter),
                         name_of_view);
INSTANTIATE_TEST_SUITE_P(Views, DivisionFrom, ::testing::Values(FloorView::kWhole, FloorView::kHalf),
                         name_of_view);

TEST(CheckLines, JudgeNothingWhereNoLineIsInTheImage) {
  PaintedFloor floor;
  floor.field = floor_field(0);
  LensCamera camera = floor_camera({});
  camera.position_mm += Eigen::Vector3d(20'000, 0, 0);
  EXPECT_EQ(looked_for(draw_floor(floor, camera), camera, floor.field).lines, 0);
}

}  // namespace
}  // namespace sslv::check_lines_test
