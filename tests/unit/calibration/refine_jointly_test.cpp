// SPDX-License-Identifier: Apache-2.0
#include "calibration/refine_jointly.h"

#include "calibration/way_round.h"
#include "support/painted_floor.h"

#include <ctime>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::refine_jointly_test {
namespace {

struct Pair {
  LensCamera a, b;
  FieldSize field;
  std::vector<PaintedCurve> curves;
  std::vector<RefinedCamera> seen;
};

/// Image sizes (see FloorSetting): small unless a test's bounds need larger ones.
constexpr int kUsual = 0, kSmall = 3;

/// Two cameras over the halves of a field, refined separately. `given`: the field and its lines' errors.
Pair two_halves(int size, const PaintedFloor& given) {
  Pair out;
  out.a = floor_camera({size});
  out.b = turned_round(out.a);
  out.b.center_x += 4;
  PaintedFloor floor = given;
  floor.field = out.field = floor_field(size);
  if (size == kSmall) floor.robots /= 3;
  out.curves = painted_curves(out.field);
  for (const LensCamera& camera : {out.a, out.b}) {
    MeanPicture picture;
    picture.add(draw_floor(floor, camera).view);
    CameraPrior prior = camera_prior(camera.width, camera.height);
    prior.height_mm = camera.position_mm.z() + 10;
    prior.height_sigma_mm = 10;
    auto refined = refine_camera(find_line_pixels(picture, 1.5), camera, out.curves, prior, {20, false});
    if (refined) out.seen.push_back(*refined);
  }
  return out;
}

/// The same with exact lines, in small images.
const Pair& exact_halves() {
  static const Pair pair = two_halves(kSmall, {});
  return pair;
}

/// Robots that both cameras see, with a noise of 0.1 px.
std::vector<OverlapTie> robots_in_both(const Pair& pair) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.1);
  std::vector<OverlapTie> out;
  const double width = pair.field.field_width;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d place(std::uniform_real_distribution<double>(-300, 300)(random),
                                std::uniform_real_distribution<double>(-0.47 * width, 0.47 * width)(random),
                                140);
    const auto p = pair.a.project(place), q = pair.b.project(place);
    if (!p || !q || !pair.a.is_in_picture(*p) || !pair.b.is_in_picture(*q)) continue;
    out.push_back({0, 1, *p + Eigen::Vector2d(noise(random), noise(random)),
                   *q + Eigen::Vector2d(noise(random), noise(random)), 140, 0.1});
  }
  return out;
}

TEST(RefineJointly, CamerasAgreeWhereBothSee) {
  for (const bool wavy : {false, true}) {
    PaintedFloor floor;
    (wavy ? floor.wavy_mm : floor.shifted_mm) = 1.5;
    const Pair pair = two_halves(kSmall, floor);
    ASSERT_EQ(pair.seen.size(), 2U);
    const auto ties = robots_in_both(pair);
    ASSERT_GT(ties.size(), 10U);
    const JointCalibration joint = refine_jointly(pair.seen, pair.curves, ties);
    const auto overlap_mm = [&](const LensCamera& a, const LensCamera& b, double height_mm) {
      return overlap_error_mm(pair.a, pair.b, a, b, pair.field, height_mm);
    };
    const double before_mm = overlap_mm(pair.seen[0].camera, pair.seen[1].camera, 0);
    EXPECT_LT(overlap_mm(joint.cameras[0], joint.cameras[1], 0), 0.7);
    EXPECT_LT(overlap_mm(joint.cameras[0], joint.cameras[1], 0), before_mm);
    EXPECT_LT(overlap_mm(joint.cameras[0], joint.cameras[1], 150), 0.8);
    // The result's own figures agree.
    EXPECT_GT(joint.overlapping_patches, 50);
    EXPECT_LT(joint.disagreement_mm, joint.disagreement_before_mm);
    // The field as a whole stays aligned with its lines.
    EXPECT_LT(field_error_mm(pair.a, joint.cameras[0], pair.field, 0), 1.5 * 1.5);
    EXPECT_LT(field_error_mm(pair.b, joint.cameras[1], pair.field, 0), 1.5 * 1.5);
  }
}

TEST(RefineJointly, LeavesExactCamerasAlone) {
  const Pair pair = two_halves(kUsual, {});
  ASSERT_EQ(pair.seen.size(), 2U);
  const JointCalibration joint = refine_jointly(pair.seen, pair.curves, {});
  EXPECT_LT(field_error_mm(pair.a, joint.cameras[0], pair.field, 0), 0.2);
  EXPECT_LT(field_error_mm(pair.b, joint.cameras[1], pair.field, 0), 0.2);
}

TEST(RefineJointly, ASingleCameraHasNoDisagreement) {
  Pair pair = exact_halves();
  ASSERT_EQ(pair.seen.size(), 2U);
  pair.seen.pop_back();
  const JointCalibration joint = refine_jointly(pair.seen, pair.curves, {});
  EXPECT_EQ(joint.overlapping_patches, 0);
  EXPECT_EQ(joint.disagreement_mm, 0);
  EXPECT_LT(field_error_mm(pair.a, joint.cameras[0], pair.field, 0), 0.2);
}

TEST(RefineJointly, AStopEndsTheSolver) {
  const Pair& pair = exact_halves();
  ASSERT_EQ(pair.seen.size(), 2U);
  // With this many ties, one solver step takes seconds.
  std::vector<OverlapTie> ties;
  for (const OverlapTie& tie : robots_in_both(pair)) ties.insert(ties.end(), 30, tie);
  std::stop_source stop;
  stop.request_stop();
  const std::clock_t begin = std::clock();  // CPU time: other processes do not count
  refine_jointly(pair.seen, pair.curves, ties, stop.get_token());
  EXPECT_LT(std::clock() - begin, 3 * CLOCKS_PER_SEC);
}

}  // namespace
}  // namespace sslv::refine_jointly_test
