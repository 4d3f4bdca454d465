// SPDX-License-Identifier: Apache-2.0
#include "geometry/camera_model.h"

#include "base/error.h"
#include "base/json.h"
#include "support/test_data.h"

#include <fstream>
#include <map>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gmock/gmock.h>

namespace sslv::camera_model_test {
namespace {

/// The protocol's example: a camera 3.5 m above (1250, 0); the image's right is the field's -y, its down is
/// -x.
CameraCalibration overhead() {
  CameraCalibration c;
  c.focal_length = 600;
  c.principal_point_x = 390;
  c.principal_point_y = 290;
  c.q0 = std::sqrt(0.5);
  c.q1 = -std::sqrt(0.5);
  c.q2 = c.q3 = 0;
  c.tx = 0;
  c.ty = 1250;
  c.tz = 3500;
  c.pixel_image_width = 780;
  c.pixel_image_height = 580;
  return c;
}

/// A camera 2 to 6 m above the field, tilted by up to 30 degrees, with any image size and any distortion that
/// is valid for it.
CameraCalibration random_camera(std::mt19937& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  CameraCalibration c;
  c.pixel_image_width = static_cast<int>(uniform(640, 2600));
  c.pixel_image_height = static_cast<int>(c.pixel_image_width * uniform(0.5, 1));
  c.focal_length = c.pixel_image_width * uniform(0.4, 2);
  c.principal_point_x = c.pixel_image_width * uniform(0.45, 0.55);
  c.principal_point_y = c.pixel_image_height * uniform(0.45, 0.55);
  const double dx = std::max(c.principal_point_x + 0.5, c.pixel_image_width - 0.5 - c.principal_point_x);
  const double dy = std::max(c.principal_point_y + 0.5, c.pixel_image_height - 0.5 - c.principal_point_y);
  const double corner = std::hypot(dx, dy) / c.focal_length;
  c.distortion = uniform(-0.99 / (3 * corner * corner), 1);
  const Eigen::Quaterniond down(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(
      uniform(-0.5, 0.5), Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), 0.1).normalized()));
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(uniform(-3, 3), Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond q = tilt * down * turn;
  const Eigen::Vector3d t =
      -(q * Eigen::Vector3d(uniform(-6000, 6000), uniform(-4500, 4500), uniform(2000, 6000)));
  c.q0 = q.x(), c.q1 = q.y(), c.q2 = q.z(), c.q3 = q.w();
  c.tx = t.x(), c.ty = t.y(), c.tz = t.z();
  return c;
}

TEST(CameraModel, FollowsTheProtocolsExample) {
  const CameraModel camera(overhead());
  EXPECT_LT((camera.position_mm() - Eigen::Vector3d(1250, 0, 3500)).norm(), 1e-9);

  const auto center = camera.project({1250, 0, 0});
  ASSERT_TRUE(center.has_value());
  EXPECT_NEAR(center->x(), 390, 1e-9);
  EXPECT_NEAR(center->y(), 290, 1e-9);
  const auto right = camera.project({1250, -350, 0});  // 600 px * 350 / 3500
  EXPECT_NEAR(right->x(), 390 + 60, 1e-9);
  EXPECT_NEAR(right->y(), 290, 1e-9);
  const auto below = camera.project({1250 - 350, 0, 0});
  EXPECT_NEAR(below->x(), 390, 1e-9);
  EXPECT_NEAR(below->y(), 290 + 60, 1e-9);
}

TEST(CameraModel, HigherPointsAreFartherFromTheCentre) {
  const CameraModel camera(overhead());
  EXPECT_NEAR(camera.project({1250, -350, 1750})->x(), 390 + 120, 1e-9);
  EXPECT_NEAR(camera.unproject({390 + 120, 290}, 1750)->y(), -350, 1e-9);
}

// ru = rd (1 + d rd^2): with f = 600 and d = 0.5, 300 px from the centre (rd = 0.5) give ru = 0.5625.
TEST(CameraModel, DistortionIsRadialInTheDistortedRadius) {
  CameraCalibration c = overhead();
  c.distortion = 0.5;
  const CameraModel camera(c);
  const auto place = camera.unproject({390 + 300, 290}, 0);
  EXPECT_NEAR(place->y(), -0.5625 * 3500, 1e-9);
  EXPECT_NEAR(place->x(), 1250, 1e-9);
  EXPECT_NEAR(camera.project({1250, -0.5625 * 3500, 0})->x(), 390 + 300, 1e-9);
}

TEST(CameraModel, ProjectAndUnprojectAreInverses) {
  std::mt19937 random(1);
  int checked = 0, negative = 0;
  for (int n = 0; n < 300; ++n) {
    const CameraCalibration c = random_camera(random);
    const CameraModel camera(c);
    negative += c.distortion < 0;
    std::uniform_real_distribution<double> x(-0.5, c.pixel_image_width - 0.5);
    std::uniform_real_distribution<double> y(-0.5, c.pixel_image_height - 0.5), height(0, 200);
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d pixel(x(random), y(random));
      const double h = height(random);
      const auto place = camera.unproject(pixel, h);
      if (!place) continue;  // above the horizon
      const auto back = camera.project({place->x(), place->y(), h});
      ASSERT_TRUE(back.has_value());
      ASSERT_LT((*back - pixel).norm(), 1e-6)
          << "distortion " << c.distortion << " pixel " << pixel.transpose();
      ++checked;
    }
  }
  EXPECT_GT(checked, 10000);
  EXPECT_GT(negative, 30);
}

TEST(CameraModel, RaysLeadFromTheCameraToThePixelsPlace) {
  CameraCalibration c = overhead();
  c.distortion = -0.2;
  const CameraModel camera(c);
  const auto ray = camera.ray({100, 500});
  ASSERT_TRUE(ray.has_value());
  const auto place = camera.unproject({100, 500}, 20);
  const Eigen::Vector3d to_place = Eigen::Vector3d(place->x(), place->y(), 20) - camera.position_mm();
  EXPECT_LT(ray->cross(to_place).norm() / to_place.norm(), 1e-9);
  EXPECT_GT(ray->dot(to_place), 0);
}

TEST(CameraModel, PointsBehindTheCameraHaveNoPicture) {
  const CameraModel camera(overhead());
  EXPECT_FALSE(camera.project({1250, 0, 3500}).has_value());
  EXPECT_FALSE(camera.project({1250, 0, 4000}).has_value());
  EXPECT_FALSE(camera.unproject({390, 290}, 3501).has_value()) << "a plane above the camera";
}

TEST(CameraModel, PixelsAboveTheHorizonHaveNoPlace) {
  CameraCalibration c = overhead();
  // Looks horizontally along the field's +y: the image's upper half shows no floor.
  const Eigen::Quaterniond q(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
  c.q0 = q.x(), c.q1 = q.y(), c.q2 = q.z(), c.q3 = q.w();
  const Eigen::Vector3d t = -(q * Eigen::Vector3d(0, 0, 1000));
  c.tx = t.x(), c.ty = t.y(), c.tz = t.z();
  const CameraModel camera(c);
  EXPECT_TRUE(camera.unproject({390, 400}, 0).has_value());
  EXPECT_FALSE(camera.unproject({390, 100}, 0).has_value());
  EXPECT_EQ(camera.mm2_per_px({390, 100}, 0), 0);
}

TEST(CameraModel, PointsBeyondABarrelLensRangeHaveNoPicture) {
  CameraCalibration c = overhead();
  c.distortion = -0.3;  // one-to-one up to rd = 1.054, ru = 0.703
  const CameraModel camera(c);
  EXPECT_TRUE(camera.project({1250, 0.69 * 3500, 0}).has_value());
  EXPECT_FALSE(camera.project({1250, 0.71 * 3500, 0}).has_value());
  EXPECT_TRUE(camera.unproject({390 + 1.04 * 600, 290}, 0).has_value());
  EXPECT_FALSE(camera.unproject({390 + 1.07 * 600, 290}, 0).has_value());
}

TEST(CameraModel, RefusesADistortionThatIsNotOneToOneInThePicture) {
  CameraCalibration c = overhead();
  const double corner = std::hypot(390.5, 290.5) / 600;
  c.distortion = -1 / (3 * corner * corner) + 1e-6;
  EXPECT_NO_THROW(CameraModel{c});
  c.distortion -= 2e-6;
  try {
    CameraModel(c, "/cameras/1/calibration");
    FAIL() << "accepted";
  } catch (const SettingsError& error) {
    EXPECT_THAT(error.what(),
                testing::MatchesRegex("/cameras/1/calibration/distortion: -0\\.50.* is not allowed; "
                                      "expected more than -0\\.5.*corners"));
  }
}

TEST(CameraModel, RefusesAQuaternionThatIsNoRotation) {
  CameraCalibration c = overhead();
  c.q0 = c.q1 = c.q2 = c.q3 = 0;
  try {
    CameraModel(c, "/cameras/1/calibration");
    FAIL() << "accepted";
  } catch (const SettingsError& error) {
    EXPECT_STREQ(error.what(),
                 "/cameras/1/calibration: q0..q3 has length 0; a rotation needs a quaternion of length 1");
  }
  c = overhead();
  c.q0 *= 1.002;
  EXPECT_THROW(CameraModel{c}, SettingsError);
}

TEST(CameraModel, NormalisesAQuaternionOfFewDigits) {
  CameraCalibration c = overhead();
  c.q0 = 0.7071, c.q1 = -0.7071;
  EXPECT_LT((CameraModel(c).position_mm() - Eigen::Vector3d(1250, 0, 3500)).norm(), 1e-9);
}

TEST(CameraModel, AreaOfAPixelGrowsWithTheDistance) {
  const CameraModel camera(overhead());
  const double side_mm = 3500.0 / 600;
  EXPECT_NEAR(camera.mm2_per_px({390, 290}, 0), side_mm * side_mm, 1e-9);
  EXPECT_NEAR(camera.mm2_per_px({10, 10}, 1750), side_mm * side_mm / 4, 1e-9);
}

// Positions published by a league's vision, with their pixels and the calibration in use: our model must map
// one to the other.
TEST(CameraModel, AgreesWithPositionsPublishedAtATournament) {
  const auto data = test_data_folder();
  std::ifstream calibrations(data / "logs" / "larc2016_calibrations.json");
  std::ifstream pairs(data / "logs" / "larc2016_pixel_field_pairs.jsonl");
  if (!calibrations || !pairs) GTEST_SKIP() << "no recorded pairs in " << data;

  std::map<int, CameraModel> cameras;
  const Json published_calibrations = Json::parse(calibrations);
  for (const auto& [id, json] : published_calibrations.items()) {
    CameraCalibration c;
    c.focal_length = json.at("focal_length");
    c.principal_point_x = json.at("cx");
    c.principal_point_y = json.at("cy");
    c.distortion = json.at("distortion");
    c.q0 = json.at("q0"), c.q1 = json.at("q1"), c.q2 = json.at("q2"), c.q3 = json.at("q3");
    c.tx = json.at("tx"), c.ty = json.at("ty"), c.tz = json.at("tz");
    const CameraModel& camera = cameras.emplace(std::stoi(id), c).first->second;
    const Eigen::Vector3d published(json.at("cam_wx"), json.at("cam_wy"), json.at("cam_wz"));
    EXPECT_LT((camera.position_mm() - published).norm(), 0.05) << "camera " << id;  // q has six digits
  }

  int count = 0;
  for (std::string line; std::getline(pairs, line);) {
    const Json pair = Json::parse(line);
    const CameraModel& camera = cameras.at(pair.at("cam"));
    const Eigen::Vector2d pixel(pair.at("px"), pair.at("py")), field(pair.at("x"), pair.at("y"));
    const double height = pair.at("h");
    const auto place = camera.unproject(pixel, height);
    ASSERT_TRUE(place.has_value()) << line;
    ASSERT_LT((*place - field).norm(), 0.01) << line;
    const auto picture = camera.project({field.x(), field.y(), height});
    ASSERT_TRUE(picture.has_value()) << line;
    ASSERT_LT((*picture - pixel).norm() * std::sqrt(camera.mm2_per_px(pixel, height)), 0.01) << line;
    ++count;
  }
  EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace sslv::camera_model_test
