// SPDX-License-Identifier: Apache-2.0
#include "net/vision_message.h"

#include "geometry/limits.h"
#include "net/packets.h"
#include "support/paths.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <type_traits>

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace sslv::vision_message_test {
namespace {

using testing::HasSubstr;

static_assert(!std::is_default_constructible_v<VisionMessage>, "there is one door");

std::optional<VisionMessage> message_of(const SSL_WrapperPacket& packet) {
  const std::string bytes = packet.SerializeAsString();
  return VisionMessage::read(std::as_bytes(std::span(bytes)));
}

SSL_WrapperPacket detection(std::size_t robots, std::size_t balls) {
  RobotList all;
  for (std::size_t i = 0; i < robots; ++i) {
    all.robots.push_back(
        {i % 2 == 0 ? Team::kBlue : Team::kYellow, static_cast<int>(i % 256), 100, 200, 0.5, 150, 0, 0, 0.9});
  }
  SSL_WrapperPacket packet;
  write_detection({.camera_id = 3, .number = 7, .times = {.t_capture_s = 1000}}, all,
                  {std::vector<Ball>(balls, Ball{1, 2, 0, 0, 60, 0.8})}, 1000.01, packet);
  return packet;
}

TEST(VisionMessage, SaysWhatAPacketSays) {
  const auto message = message_of(detection(2, 1));
  ASSERT_TRUE(message && message->detection);
  EXPECT_FALSE(message->field);
  EXPECT_EQ(message->detection->t_sent_s, 1000.01);
  const CameraSightings& image = message->detection->arrived.image;
  EXPECT_EQ(image.camera, 3);
  EXPECT_EQ(image.frame_number, 7U);
  EXPECT_EQ(image.robots.size(), 2U);
  EXPECT_EQ(image.balls.size(), 1U);
  EXPECT_EQ(message->detection->arrived.left_out, 0U);
}

TEST(VisionMessage, LeavesOutSightingsOutsideTheLimits) {
  SSL_WrapperPacket packet = detection(2, 2);
  auto& robots = *packet.mutable_detection()->mutable_robots_blue();
  const SSL_DetectionRobot good = robots[0];
  const auto add = [&](const auto& spoil) {
    SSL_DetectionRobot one = good;
    spoil(one);
    *robots.Add() = one;
  };
  add([](auto& one) { one.clear_robot_id(); });
  add([](auto& one) { one.set_robot_id(256); });
  add([](auto& one) { one.set_robot_id(4'000'000'000U); });
  add([](auto& one) { one.clear_orientation(); });
  add([](auto& one) { one.set_orientation(std::numeric_limits<float>::infinity()); });
  add([](auto& one) { one.set_height(1001); });
  add([](auto& one) { one.set_height(-1); });
  add([](auto& one) { one.set_height(std::nanf("")); });
  add([](auto& one) { one.set_x(1.1e6F); });
  packet.mutable_detection()->mutable_balls(1)->set_y(-1.1e6F);
  const auto message = message_of(packet);
  ASSERT_TRUE(message && message->detection);
  EXPECT_EQ(message->detection->arrived.image.robots.size(), 2U);
  EXPECT_EQ(message->detection->arrived.image.balls.size(), 1U);
  EXPECT_EQ(message->detection->arrived.left_out, 10U);
}

/// Within the limits, sums and differences of two clocks are finite.
TEST(VisionMessage, HasNoTimesOutsideTheLimits) {
  for (const double t_s : {1e12, -1e308, std::numeric_limits<double>::infinity(), std::nan("")}) {
    SSL_WrapperPacket packet = detection(1, 1);
    packet.mutable_detection()->set_t_sent(t_s);
    EXPECT_FALSE(message_of(packet)) << t_s;
    packet = detection(1, 1);
    packet.mutable_detection()->set_t_capture(t_s);
    EXPECT_FALSE(message_of(packet)) << t_s;
  }
}

TEST(VisionMessage, HasNoLongLists) {
  const auto message = message_of(detection(400, 600));
  ASSERT_TRUE(message && message->detection);
  EXPECT_EQ(message->detection->arrived.image.robots.size(), limits::kMaxRobots);
  EXPECT_EQ(message->detection->arrived.image.balls.size(), limits::kMaxFieldBalls);
  SSL_WrapperPacket packet;
  CameraCalibration above;
  above.q0 = 1;
  above.q3 = 0;
  above.tz = 4000;
  Geometry geometry;
  for (std::uint32_t id = 0; id < 100; ++id) geometry.cameras.push_back({id, CameraModel(above)});
  write_geometry(geometry, packet);
  EXPECT_EQ(message_of(packet)->cameras.size(), limits::kMaxCameras);
}

TEST(VisionMessage, ATeamOfManyRobotsLeavesRoomForTheOther) {
  for (const bool yellow_has_many : {false, true}) {
    SSL_WrapperPacket packet = detection(2, 0);
    SSL_DetectionFrame& frame = *packet.mutable_detection();
    auto& many = yellow_has_many ? *frame.mutable_robots_yellow() : *frame.mutable_robots_blue();
    for (std::size_t i = 1; i < limits::kMaxRobots; ++i) {
      const SSL_DetectionRobot one = many[0];
      *many.Add() = one;
    }
    const auto message = message_of(packet);
    ASSERT_TRUE(message && message->detection);
    const auto& robots = message->detection->arrived.image.robots;
    EXPECT_EQ(robots.size(), limits::kMaxRobots / 2 + 1);
    EXPECT_EQ(std::ranges::count(robots, yellow_has_many ? Team::kBlue : Team::kYellow, &RobotSighting::team),
              1);
    EXPECT_EQ(message->detection->arrived.left_out, limits::kMaxRobots / 2);
  }
}

TEST(VisionMessage, DropsCamerasAtInvalidPositions) {
  SSL_WrapperPacket packet;
  write_geometry({}, packet);
  const auto add = [&](float x_mm, float z_mm, std::uint32_t id = 1) {
    auto& camera = *packet.mutable_geometry()->add_calib();
    camera.set_camera_id(id);
    for (const auto set :
         {&SSL_GeometryCameraCalibration::set_focal_length,
          &SSL_GeometryCameraCalibration::set_principal_point_x,
          &SSL_GeometryCameraCalibration::set_principal_point_y,
          &SSL_GeometryCameraCalibration::set_distortion, &SSL_GeometryCameraCalibration::set_q0,
          &SSL_GeometryCameraCalibration::set_q1, &SSL_GeometryCameraCalibration::set_q2,
          &SSL_GeometryCameraCalibration::set_q3, &SSL_GeometryCameraCalibration::set_tx,
          &SSL_GeometryCameraCalibration::set_ty, &SSL_GeometryCameraCalibration::set_tz})
      (camera.*set)(0);
    if (z_mm != 0) camera.set_derived_camera_world_tz(z_mm);
    camera.set_derived_camera_world_tx(x_mm);
  };
  add(0, 0);
  add(0, 299);
  add(0, -4000);
  add(0, 200'000);
  add(std::nanf(""), 4000);
  add(0, std::numeric_limits<float>::infinity());
  add(0, 4000, 256);
  ASSERT_TRUE(message_of(packet));
  EXPECT_TRUE(message_of(packet)->cameras.empty());
  add(0, 4000, 255);
  EXPECT_EQ(message_of(packet)->cameras.size(), 1U);
}

/// docs/protocol.md lists the limits.
TEST(VisionMessage, TheDocsListItsLimits) {
  std::ifstream in(source_path("/docs/protocol.md"));
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto row = [&](const char* what, const auto& value) {
    EXPECT_THAT(text, HasSubstr(fmt::format("| {} | {} |", what, value)));
  };
  row("ids of robots and cameras", fmt::format("0 to {}", limits::kMaxId));
  row("places (mm, px), speeds (mm/s)", fmt::format("-{0:.0f} to {0:.0f}", limits::kMaxPlaceMm));
  row("times of a packet (s)", fmt::format("-{0:.0f} to {0:.0f}", limits::kMaxTime_s));
  row("height of a robot's pattern", fmt::format("0 to {:.0f} mm, and {:.0f} mm below its camera",
                                                 limits::kMaxRobotHeightMm, limits::kMinAboveRobotMm));
  row("where a camera hangs", fmt::format("{:.0f} mm above the floor or higher, up to {:.0f} mm away",
                                          limits::kMinCameraMm, limits::kMaxCameraMm));
  row("robots in an image, a packet, the tracks", limits::kMaxRobots);
  row("robots of a team in a packet of another vision", limits::kMaxRobots / 2);
  row("balls in an image's detections", limits::kMaxBalls);
  row("balls of an image for the tracks, balls in the tracks", limits::kMaxFieldBalls);
  row("cameras of one computer, cameras that are tracked together", limits::kMaxCameras);
  row("computers that are named, others that are listed", limits::kMaxComputers);
  row("cameras of computers that are not named, together", limits::kMaxUnnamedCameras);
}

}  // namespace
}  // namespace sslv::vision_message_test
