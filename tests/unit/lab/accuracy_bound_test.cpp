// SPDX-License-Identifier: Apache-2.0
#include "lab/accuracy_bound.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace sslv::accuracy_bound_test {
namespace {

constexpr double kPxPerMm = 0.5, kHeightMm = 140, kBlurPx = 1.5, kSigma = 4, kContrast = 80;
constexpr int kSize = 160;

/// Looks straight down on the middle of the field.
CameraCalibration camera_above() {
  CameraCalibration c;
  c.q0 = 1, c.q3 = 0;
  c.tz = 4140;
  c.focal_length = kPxPerMm * 4000;
  c.principal_point_x = c.principal_point_y = 79.5;
  c.pixel_image_width = c.pixel_image_height = kSize;
  return c;
}

class AccuracyBoundTest : public ::testing::Test {
 protected:
  AccuracyBoundTest() : bytes_(3 * kSize * kSize) {
    const PatternTable& patterns = league_patterns();
    dots_.push_back({0, 0, patterns.center_diameter_mm});
    dots_.insert(dots_.end(), patterns.dots.begin(), patterns.dots.end());
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        double value = 20;
        for (const PatternDot& dot : dots_) {
          const auto at = camera_.project({pose_.x_mm + dot.x_mm, pose_.y_mm + dot.y_mm, kHeightMm});
          const double inside = kPxPerMm * dot.diameter_mm / 2 - std::hypot(x - at->x(), y - at->y());
          value += kContrast * 0.5 * std::erfc(-inside / (kEdgePx * std::numbers::sqrt2));
        }
        for (int c = 0; c < 3; ++c) {
          bytes_[static_cast<std::size_t>(3 * (y * kSize + x) + c)] =
              static_cast<std::uint8_t>(std::lround(value));
        }
      }
    }
  }

  // The area of a pixel also blurs: variance 1/12.
  const double kEdgePx = std::sqrt(kBlurPx * kBlurPx + 1.0 / 12);
  const BoundPose pose_{3, -5, 0, kHeightMm};
  CameraModel camera_{camera_above()};
  std::vector<PatternDot> dots_;
  std::vector<std::uint8_t> bytes_;
  ImageView view_{bytes_.data(), kSize, kSize, 3 * kSize, PixelFormat::kRgb24};
  BoundPicture picture_{view_, camera_, league_patterns(), kBlurPx, kSigma};
};

TEST_F(AccuracyBoundTest, IsThatOfBlurredEdgesInClosedForm) {
  // Fisher information of an edge of length l about its position across the edge: contrast^2 l / (2 sqrt(pi)
  // edge sigma^2), for one sample per square pixel. A circle has half of that along x.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const PatternDot& dot : dots_) {
    const double around_px = std::numbers::pi * kPxPerMm * dot.diameter_mm;
    const double one = 3 * kContrast * kContrast / (kSigma * kSigma + 1.0 / 12) * around_px / 2 /
                       (2 * std::sqrt(std::numbers::pi) * kEdgePx) * kPxPerMm * kPxPerMm;
    Eigen::Matrix<double, 2, 3> by_pose;
    by_pose << 1, 0, -dot.y_mm, 0, 1, dot.x_mm;
    information += one * by_pose.transpose() * by_pose;
  }
  const Eigen::Matrix3d covariance = information.inverse();
  const auto bound = robot_bound(picture_, {&pose_, 1});
  ASSERT_TRUE(bound);
  EXPECT_NEAR(bound->position_mm, std::sqrt(covariance(0, 0) + covariance(1, 1)), 0.02 * bound->position_mm);
  EXPECT_NEAR(bound->orientation_rad, std::sqrt(covariance(2, 2)), 0.02 * bound->orientation_rad);
}

TEST_F(AccuracyBoundTest, GrowsWithNoiseAndWithMotion) {
  const double still = robot_bound(picture_, {&pose_, 1})->position_mm;
  picture_.noise_sigma = 2 * kSigma;
  EXPECT_NEAR(robot_bound(picture_, {&pose_, 1})->position_mm, 2 * still, 0.02 * still);
  picture_.noise_sigma = kSigma;
  std::array<BoundPose, 8> moving;
  for (std::size_t i = 0; i < moving.size(); ++i)
    moving[i] = {pose_.x_mm + 5 * (static_cast<double>(i) - 3.5), pose_.y_mm, 0, kHeightMm};
  EXPECT_GT(robot_bound(picture_, moving)->position_mm, 1.2 * still);
}

TEST_F(AccuracyBoundTest, AThirdOfTheValuesHasAThirdOfTheInformation) {
  // A Bayer image of the same grey scene has a third of the RGB image's values.
  std::vector<std::uint8_t> mosaic(kSize * kSize);
  for (std::size_t i = 0; i < mosaic.size(); ++i) mosaic[i] = bytes_[3 * i];
  const double rgb = robot_bound(picture_, {&pose_, 1})->position_mm;
  const ImageView bayer{mosaic.data(), kSize, kSize, kSize, PixelFormat::kBayerRg8};
  const BoundPicture picture{bayer, camera_, league_patterns(), kBlurPx, kSigma};
  EXPECT_NEAR(robot_bound(picture, {&pose_, 1})->position_mm, std::sqrt(3) * rgb, 0.02 * rgb);
}

TEST_F(AccuracyBoundTest, ThereIsNoneForARobotAtThePicturesRim) {
  const BoundPose outside{150, 0, 0, kHeightMm};
  EXPECT_FALSE(robot_bound(picture_, {&outside, 1}));
}

}  // namespace
}  // namespace sslv::accuracy_bound_test
