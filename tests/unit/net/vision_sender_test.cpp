// SPDX-License-Identifier: Apache-2.0
#include "net/vision_sender.h"

#include "base/clock.h"
#include "support/allocation_count.h"
#include "support/group_listener.h"

#include <gmock/gmock.h>

namespace sslv::vision_sender_test {
namespace {

using std::chrono::duration;

SSL_WrapperPacket receive(GroupListener& listener) {
  SSL_WrapperPacket packet;
  const auto datagram = listener.receive();
  EXPECT_TRUE(datagram && packet.ParseFromString(*datagram));
  return packet;
}

Robot robot(int id) {
  return {.team = id % 2 == 0 ? Team::kYellow : Team::kBlue,
          .id = id,
          .x_mm = 10.0 * id,
          .y_mm = 0,
          .orientation_rad = 0,
          .height_mm = 140,
          .pixel_x = 0,
          .pixel_y = 0,
          .confidence = 0.1 * id};
}

TEST(DetectionSender, SendsOnePacketAFrameAlsoWhenNothingWasFound) {
  GroupListener listener;
  MulticastSender out(settings_for(listener));
  DetectionSender sender(out);
  const double before_s = unix_time_s();
  const double first_s = sender.send({.camera_id = 2, .number = 5, .times = {1}}, {{robot(3)}}, {});
  const double second_s = sender.send({.camera_id = 2, .number = 6, .times = {2}}, {}, {});
  EXPECT_LE(before_s, first_s);
  EXPECT_LE(second_s, unix_time_s());

  const SSL_WrapperPacket first = receive(listener), second = receive(listener);
  EXPECT_EQ(first.source(), SSL_SOURCE_OTHER);
  EXPECT_EQ(first.detection().camera_id(), 2U);
  EXPECT_EQ(first.detection().frame_number(), 5U);
  EXPECT_EQ(first.detection().t_sent(), first_s);
  EXPECT_EQ(first.detection().robots_blue_size(), 1);
  EXPECT_EQ(second.detection().frame_number(), 6U);
  EXPECT_EQ(second.detection().t_sent(), second_s);
  EXPECT_EQ(second.detection().robots_blue_size(), 0);
}

TEST(DetectionSender, AllocatesNothingInSteadyState) {
  if (!counts_allocations()) GTEST_SKIP() << "allocations are not counted in this build";
  GroupListener listener;
  MulticastSender out(settings_for(listener));
  DetectionSender sender(out);
  RobotList full;
  BallList balls;
  for (int id = 0; id < 16; ++id) full.robots.push_back(robot(id));
  for (int i = 0; i < 5; ++i) balls.balls.push_back({0, 0, 0, 0, 40, 0.2 * i});
  const RobotList none;
  FrameInfo info{.camera_id = 0, .number = 0, .times = {0, 0}};
  const auto publish = [&] {
    sender.send(info, info.number % 2 == 0 ? full : none, balls);  // counts vary, as on a field
    ++info.number;
  };
  publish();
  ASSERT_GT(allocation_count(), 0U);
  const std::uint64_t before = allocation_count();
  for (int i = 0; i < 1000; ++i) publish();
  EXPECT_EQ(allocation_count() - before, 0U);
  EXPECT_EQ(out.status().packets_sent + out.status().send_errors, 1001U);
}

TEST(GeometrySender, SendsAgainAndAgainWithoutAnyCamera) {
  GroupListener listener;
  MulticastSender out(settings_for(listener));
  const Snapshot<Geometry> geometry{Geometry{}};
  const GeometrySender sender(out, geometry, duration<double>(0.01));
  for (int i = 0; i < 3; ++i) {
    const SSL_WrapperPacket packet = receive(listener);
    EXPECT_EQ(packet.source(), SSL_SOURCE_OTHER);
    EXPECT_FALSE(packet.has_detection());
    EXPECT_EQ(packet.geometry().field().field_length(), 9000);
    EXPECT_EQ(packet.geometry().calib_size(), 0);
  }
}

TEST(GeometrySender, SendsAChangeAtOnce) {
  GroupListener listener;
  MulticastSender out(settings_for(listener));
  Snapshot<Geometry> geometry{Geometry{}};
  GeometrySender sender(out, geometry, duration<double>(3600));
  EXPECT_EQ(receive(listener).geometry().field().field_length(), 9000);

  Geometry changed;
  changed.field.field_length = 12000;
  changed.cameras.push_back({3, CameraModel(CameraCalibration{})});
  geometry.store(std::move(changed));
  sender.restart(duration<double>(3600));
  const SSL_WrapperPacket packet = receive(listener);
  EXPECT_EQ(packet.geometry().field().field_length(), 12000);
  ASSERT_EQ(packet.geometry().calib_size(), 1);
  EXPECT_EQ(packet.geometry().calib(0).camera_id(), 3U);
}

TEST(GeometrySender, WaitsForTheFirstGeometry) {
  GroupListener listener;
  MulticastSender out(settings_for(listener));
  Snapshot<Geometry> geometry;
  GeometrySender sender(out, geometry, duration<double>(3600));
  geometry.store(Geometry{});
  sender.restart(duration<double>(3600));
  EXPECT_EQ(receive(listener).geometry().field().field_length(), 9000);
}

}  // namespace
}  // namespace sslv::vision_sender_test
