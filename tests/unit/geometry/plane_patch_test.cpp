// SPDX-License-Identifier: Apache-2.0
#include "geometry/plane_patch.h"

#include "support/drawn_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace sslv::plane_patch_test {
namespace {

constexpr double kReachMm = 90;

/// Calls `use` with places all over the image where a patch of 90 mm is fully in view.
template <class Use>
void for_places(const CameraModel& camera, double height_mm, const Use& use) {
  for (int u = 30; u <= 750; u += 90) {
    for (int v = 30; v <= 550; v += 65) {
      const auto place = camera.unproject(Eigen::Vector2d(u, v), height_mm);
      if (place) use(*place);
    }
  }
}

Eigen::Vector2d around(int i, double reach_mm) {
  const double angle = i * std::numbers::pi / 12;
  return reach_mm * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

/// Largest difference from the camera model at a distance of `reach_mm`, in mm on the plane; 1e9 without a
/// patch.
double worst_mm(const CameraModel& camera, const Eigen::Vector2d& place, double height_mm, double reach_mm) {
  const auto patch = plane_patch(camera, place, height_mm, kReachMm);
  if (!patch) return 1e9;
  double worst = 0;
  for (int i = 0; i < 24; ++i) {
    const Eigen::Vector2d offset = around(i, reach_mm), there = place + offset;
    const auto pixel = camera.project({there.x(), there.y(), height_mm});
    if (!pixel) return 1e9;
    const Eigen::Vector2d d = *pixel - patch->pixel;
    worst = std::max(worst, (patch->to_plane(d.x(), d.y()) - offset).norm());
  }
  return worst;
}

TEST(PlanePatch, AgreesWithTheCameraLookingStraightDown) {
  const CameraModel camera(overhead_camera());
  for (const double height_mm : {0.0, 21.5, 140.0}) {
    for_places(camera, height_mm, [&](const Eigen::Vector2d& place) {
      for (const double reach_mm : {30.0, 60.0, kReachMm})
        EXPECT_LT(worst_mm(camera, place, height_mm, reach_mm), 0.01) << place.transpose() << " " << reach_mm;
    });
  }
}

TEST(PlanePatch, AgreesWithTheCameraTilted) {
  const CameraModel camera(oblique_camera());
  for (const double height_mm : {0.0, 21.5, 140.0}) {
    for_places(camera, height_mm, [&](const Eigen::Vector2d& place) {
      for (const double reach_mm : {30.0, 60.0, kReachMm})
        EXPECT_LT(worst_mm(camera, place, height_mm, reach_mm), 0.015)
            << place.transpose() << " " << reach_mm;
    });
  }
}

TEST(PlanePatch, ThereAndBack) {
  for (const CameraCalibration& calibration : {overhead_camera(), oblique_camera()}) {
    const CameraModel camera(calibration);
    for_places(camera, 140, [&](const Eigen::Vector2d& place) {
      const auto patch = plane_patch(camera, place, 140, kReachMm);
      ASSERT_TRUE(patch);
      for (int i = 0; i < 24; ++i) {
        const Eigen::Vector2d offset = around(i, kReachMm), pixels = patch->to_pixel(offset);
        EXPECT_LT((patch->to_plane(pixels.x(), pixels.y()) - offset).norm(), 0.05);  // 0.01 px
      }
      EXPECT_EQ(patch->to_pixel(Eigen::Vector2d::Zero()).norm(), 0);
      EXPECT_EQ(patch->to_plane(0, 0).norm(), 0);
    });
  }
}

TEST(PlanePatch, KnowsItsPointAndScale) {
  const CameraModel camera(oblique_camera());
  for_places(camera, 21.5, [&](const Eigen::Vector2d& place) {
    const auto patch = plane_patch(camera, place, 21.5, kReachMm);
    ASSERT_TRUE(patch);
    EXPECT_EQ(patch->field_mm, place);
    EXPECT_LT((patch->pixel - *camera.project({place.x(), place.y(), 21.5})).norm(), 1e-9);
    const double mm2 = camera.mm2_per_px(patch->pixel, 21.5);
    EXPECT_NEAR(patch->mm_per_px() * patch->mm_per_px(), mm2, 0.003 * mm2);
  });
}

TEST(PlanePatch, NothingWhereTheCameraSeesNothing) {
  const CameraModel camera(overhead_camera());
  EXPECT_FALSE(plane_patch(camera, {1250, 0}, 3500, kReachMm)) << "in the camera";
  EXPECT_FALSE(plane_patch(camera, {1250, 0}, 4000, kReachMm)) << "above it";
  EXPECT_FALSE(plane_patch(camera, {std::nan(""), 0}, 0, kReachMm));

  const CameraModel oblique(oblique_camera());
  const Eigen::Vector3d sight = *oblique.ray({389.5, 289.5});
  const Eigen::Vector2d behind = oblique.position_mm().head<2>() - 20000 * sight.head<2>().normalized();
  EXPECT_FALSE(plane_patch(oblique, behind, 0, kReachMm)) << "behind the camera";
}

}  // namespace
}  // namespace sslv::plane_patch_test
