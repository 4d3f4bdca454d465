// SPDX-License-Identifier: Apache-2.0
#include "calibration/lens_camera.h"

#include "calibration/publish.h"
#include "support/painted_floor.h"

#include <cmath>

#include <gtest/gtest.h>

namespace sslv::lens_camera_test {
namespace {

template <class Use>
void for_pixels(const LensCamera& camera, const Use& use) {
  for (int v = 0; v <= 4; ++v) {
    for (int u = 0; u <= 4; ++u)
      use(Eigen::Vector2d(u * (camera.width - 1) / 4.0, v * (camera.height - 1) / 4.0));
  }
}

TEST(LensCamera, UnprojectsWhatItProjects) {
  for (const double k1 : {-0.05, 0.0, 0.1, 0.4}) {
    for (const double k2 : {-0.02, 0.0, 0.05}) {
      LensCamera camera = floor_camera({0, FloorView::kHalf, 10, std::max(0.0, k1), 0});
      camera.k1 = k1;
      camera.k2 = k2;
      for_pixels(camera, [&](const Eigen::Vector2d& pixel) {
        for (const double height_mm : {0.0, 150.0}) {
          const auto place = camera.unproject(pixel, height_mm);
          ASSERT_TRUE(place);
          const auto back = camera.project({place->x(), place->y(), height_mm});
          ASSERT_TRUE(back);
          EXPECT_LT((*back - pixel).norm(), 1e-9) << k1 << " " << k2;
        }
      });
    }
  }
}

TEST(LensCamera, WithOneRadialTermIsTheWiresCamera) {
  const LensCamera camera = floor_camera({1, FloorView::kHalf, 1.5, 0.2, 0});
  const Published published = publish(camera);
  EXPECT_EQ(published.worst_mm, 0);
  const CameraModel wire(published.calibration);
  for_pixels(camera, [&](const Eigen::Vector2d& pixel) {
    const auto place = camera.unproject(pixel, 140), same = wire.unproject(pixel, 140);
    ASSERT_TRUE(place && same);
    EXPECT_LT((*place - *same).norm(), 1e-6);
  });
  const LensCamera back = lens_camera(published.calibration);
  EXPECT_LT((back.rotation - camera.rotation).norm(), 1e-12);
  EXPECT_LT((back.position_mm - camera.position_mm).norm(), 1e-6);
}

TEST(LensCamera, PublishesTheNearestWireCameraAndItsError) {
  const LensCamera camera = floor_camera({1, FloorView::kHalf, 1.5, 0.1, 0.05});
  const Published published = publish(camera);
  const CameraModel wire(published.calibration);
  double worst_mm = 0;
  for_pixels(camera, [&](const Eigen::Vector2d& pixel) {
    const auto place = camera.unproject(pixel, 0), same = wire.unproject(pixel, 0);
    ASSERT_TRUE(place && same);
    worst_mm = std::max(worst_mm, (*place - *same).norm());
  });
  EXPECT_GT(published.rms_mm, 0.1);
  EXPECT_LT(published.rms_mm, 6);
  EXPECT_LE(worst_mm, published.worst_mm * 1.3 + 0.1);
}

TEST(SteppedCamera, KnowsHowItsPicturesChange) {
  const LensCamera camera = floor_camera({0, FloorView::kHalf, 10, 0.2, 0.03});
  CameraStep at;
  at << 0.2, 3, -2, 0.02, 0.01, 0.1, -0.2, 0.15, 0.1, -0.05, 0.2;
  for (const CameraStep& here : {CameraStep(CameraStep::Zero()), at}) {
    const SteppedCamera stepped(camera, here);
    for (const Eigen::Vector3d& place :
         {Eigen::Vector3d(500, 300, 0), Eigen::Vector3d(2500, -1800, 0), Eigen::Vector3d(1000, 1000, 150)}) {
      const auto seen = stepped.project(place);
      ASSERT_TRUE(seen);
      EXPECT_LT((seen->pixel - *stepped.camera().project(place)).norm(), 1e-9);
      for (int i = 0; i < kCameraParams; ++i) {
        constexpr double kStep = 1e-6;
        CameraStep plus = here, minus = here;
        plus[i] += kStep;
        minus[i] -= kStep;
        const Eigen::Vector2d change =
            (*moved(camera, plus).project(place) - *moved(camera, minus).project(place)) / (2 * kStep);
        EXPECT_LT((change - seen->by_step.col(i)).norm(), 1e-4 * (1 + change.norm())) << "parameter " << i;
        const double rise_mm =
            (moved(camera, plus).position_mm.z() - moved(camera, minus).position_mm.z()) / (2 * kStep);
        EXPECT_NEAR(rise_mm, stepped.height_by_step()[i], 1e-2) << "parameter " << i;
      }
    }
  }
}

TEST(SteppedCamera, ZoomHardlyChangesThePictureOfAFloorSeenFromAbove) {
  const LensCamera camera = floor_camera({0, FloorView::kHalf, 0, 0.1, 0.02});
  CameraStep zoom = CameraStep::Zero();
  zoom[kZoom] = 0.3;
  const LensCamera other = moved(camera, zoom);
  EXPECT_NEAR(other.focal_px, camera.focal_px * std::exp(0.3), 1e-9);
  for_pixels(camera, [&](const Eigen::Vector2d& pixel) {
    const auto place = camera.unproject(pixel, 0);
    ASSERT_TRUE(place);
    EXPECT_LT((*other.project({place->x(), place->y(), 0}) - pixel).norm(), 5);
  });
}

}  // namespace
}  // namespace sslv::lens_camera_test
