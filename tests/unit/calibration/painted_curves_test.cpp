// SPDX-License-Identifier: Apache-2.0
#include "calibration/painted_curves.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace sslv::painted_curves_test {
namespace {

const PaintedCurve& named(const std::vector<PaintedCurve>& curves, std::string_view name) {
  const auto found = std::find_if(curves.begin(), curves.end(),
                                  [&](const PaintedCurve& curve) { return curve.name == name; });
  if (found == curves.end()) throw std::runtime_error("no " + std::string(name));
  return *found;
}

TEST(PaintedCurves, LieHalfALineInsideSizesMeasuredToTheOuterEdge) {
  const auto curves =
      painted_curves(FieldSize{}, LinesMeasured::kToOuterEdge);  // Division B, lines 10 mm wide
  EXPECT_EQ(named(curves, "TopTouchLine").from, Eigen::Vector2d(-4495, 2995));
  EXPECT_EQ(named(curves, "LeftGoalLine").to, Eigen::Vector2d(-4495, 2995));
  // The defence area's outer edges are 1000 mm from the goal line's and 2000 mm apart.
  EXPECT_EQ(named(curves, "LeftPenaltyStretch").from, Eigen::Vector2d(-3505, -995));
  EXPECT_EQ(named(curves, "RightPenaltyStretch").to, Eigen::Vector2d(3505, 995));
  EXPECT_EQ(named(curves, "RightFieldLeftPenaltyStretch").from, Eigen::Vector2d(4495, 995));
  EXPECT_EQ(named(curves, "CenterCircle").radius_mm, 495);
  EXPECT_EQ(named(curves, "HalfwayLine").from, Eigen::Vector2d(0, -2995));
}

TEST(PaintedCurves, LieWhereSizesMeasuredToTheMiddleSay) {
  const auto curves = painted_curves(FieldSize{});
  EXPECT_EQ(named(curves, "TopTouchLine").from, Eigen::Vector2d(-4500, 3000));
  EXPECT_EQ(named(curves, "LeftPenaltyStretch").from, Eigen::Vector2d(-3500, -1000));
  EXPECT_EQ(named(curves, "CenterCircle").radius_mm, 500);
}

TEST(PaintedCurves, AreTheSameOnesForBothWaysToMeasure) {
  FieldSize field;
  field.line_thickness = 15;
  field.penalty_area_depth = 16;
  field.penalty_area_width = 15;
  field.center_circle_radius = 8;
  for (int i = 0; i < 2; ++i) {
    const FieldCurves curves(field);
    ASSERT_EQ(curves.to_middle.size(), curves.to_outer_edge.size());
    for (std::size_t k = 0; k < curves.to_middle.size(); ++k)
      EXPECT_EQ(curves.to_middle[k].name, curves.to_outer_edge[k].name);
    field.center_circle_radius = 20;
  }
  EXPECT_EQ(named(painted_curves(field, LinesMeasured::kToOuterEdge), "CenterCircle").radius_mm, 12.5);
}

TEST(PaintedCurves, LinesOfTheFieldsOwnAreGivenByTheirMiddle) {
  FieldSize field;
  field.field_lines = {{"TopTouchLine", -4500, 3000, 4500, 3000, 12}};
  field.field_arcs = {{"bow", 0, 0, 800, 0, std::numbers::pi, 10}};
  const auto curves = painted_curves(field, LinesMeasured::kToOuterEdge);
  ASSERT_EQ(curves.size(), 2U);
  EXPECT_EQ(curves[0].from, Eigen::Vector2d(-4500, 3000));
  EXPECT_EQ(curves[0].width_mm, 12);
  EXPECT_EQ(curves[1].radius_mm, 800);
  EXPECT_NEAR(curves[1].length_mm(), 800 * std::numbers::pi, 1e-9);
  EXPECT_NEAR(curves[1].distance_mm({0, 700}), 100, 1e-9);
  EXPECT_NEAR(curves[1].distance_mm({810, -100}), std::hypot(10, 100), 1e-9) << "beyond its end";
}

TEST(PaintedCurves, KnowWhetherBothEndsOfTheFieldLookAlike) {
  EXPECT_TRUE(same_turned(painted_curves(FieldSize{})));
  FieldSize field;
  field.field_lines = field_lines(field);
  field.field_lines->pop_back();
  EXPECT_FALSE(same_turned(painted_curves(field)));
}

TEST(PaintedCurves, PointsKeepClearOfOtherCurvesAndEnds) {
  const auto curves = painted_curves(FieldSize{});
  const auto points = points_along(curves, 50, 40);
  EXPECT_GT(points.size(), 500U);
  for (const CurvePoint& point : points) {
    const Eigen::Vector2d place = point.place_mm.head<2>();
    EXPECT_LT(curves[point.curve].distance_mm(place), 1e-6);
    for (std::size_t i = 0; i < curves.size(); ++i) {
      if (i == point.curve) continue;
      EXPECT_GE(curves[i].distance_mm(place), 40);
    }
  }
}

TEST(NamedPoints, AreCornersAndCrossings) {
  const auto points = named_points(painted_curves(FieldSize{}));
  const auto place = [&](std::string_view name) {
    const auto found = std::find_if(points.begin(), points.end(),
                                    [&](const NamedPoint& point) { return point.name == name; });
    return found == points.end() ? Eigen::Vector2d(1e9, 1e9) : found->place_mm;
  };
  EXPECT_EQ(place("corner left top"), Eigen::Vector2d(-4500, 3000));
  EXPECT_EQ(place("corner right bottom"), Eigen::Vector2d(4500, -3000));
  EXPECT_EQ(place("halfway line bottom"), Eigen::Vector2d(0, -3000));
  EXPECT_EQ(place("defence area right top"), Eigen::Vector2d(3500, 1000));
  EXPECT_EQ(place("defence area at goal line left bottom"), Eigen::Vector2d(-4500, -1000));
  EXPECT_EQ(place("circle top"), Eigen::Vector2d(0, 500));
  EXPECT_EQ(place("centre"), Eigen::Vector2d(0, 0));
  for (const NamedPoint& a : points) {
    for (const NamedPoint& b : points) EXPECT_TRUE(&a == &b || a.name != b.name) << a.name;
  }
}

}  // namespace
}  // namespace sslv::painted_curves_test
