// SPDX-License-Identifier: Apache-2.0
//
// Round trips of the league's messages: packets from a real match, and our own.
#include "net/packets.h"
#include "recording/match_log_reader.h"
#include "recording/match_log_writer.h"
#include "ssl_vision_wrapper.pb.h"
#include "support/temporary_folder.h"
#include "support/test_data.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sslv::log_packets_test {
namespace {

using test::TemporaryFolder;

struct Counts {
  int packets = 0, detections = 0, geometries = 0;
};

/// Reads a log of the league's logger and expects each packet to serialize to the same bytes: no field may be
/// unknown or of another type.
void read_log(const std::filesystem::path& file, Counts& counts) {
  MatchLogReader reader(file);
  LoggedMessage message;
  while (reader.next(message)) {
    if (message.type != LoggedMessage::kVision2014) continue;
    const std::string payload(reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size());
    SSL_WrapperPacket packet;
    ASSERT_TRUE(packet.ParseFromString(payload)) << "packet " << counts.packets;
    ASSERT_EQ(packet.SerializeAsString(), payload) << "packet " << counts.packets;
    EXPECT_TRUE(packet.GetReflection()->GetUnknownFields(packet).empty());
    ++counts.packets;
    counts.detections += packet.has_detection();
    counts.geometries += packet.has_geometry();
  }
}

TEST(LogPackets, EveryPacketOfARealMatchReadsAndWritesBackTheSame) {
  const auto path = test_data_folder() / "logs/roboime_larc2016_cyrosxfei2.log";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no recorded match at " << path;
  Counts counts;
  read_log(path, counts);
  EXPECT_EQ(counts.packets, 7992);
  EXPECT_EQ(counts.detections + counts.geometries, counts.packets);
  EXPECT_GT(counts.geometries, 0);
}

// Our own packets, logged as by the league's logger: this test needs no recorded match.
TEST(LogPackets, EveryPacketOfOursReadsAndWritesBackTheSame) {
  CameraCalibration calibration;
  calibration.focal_length = 600;
  calibration.tz = 3500;
  const TemporaryFolder folder;
  MatchLogWriter out(folder.path() / "our.log.gz");
  std::vector<std::byte> buffer;
  for (std::uint32_t i = 0; i < 50; ++i) {
    SSL_WrapperPacket packet;
    if (i % 10 == 9) {
      write_geometry({FieldSize{}, {{i % 4, CameraModel(calibration, "")}}, BallModels{}}, packet);
    } else {
      Robot robot{};
      robot.team = Team::kBlue;
      robot.id = static_cast<int>(i % 16);
      robot.x_mm = 10.0 * i;
      Ball ball{};
      ball.x_mm = -3.0 * i;
      RobotList robots;
      robots.robots.assign(i % 7, robot);
      BallList balls;
      balls.balls.assign(i % 3, ball);
      write_detection(FrameInfo{.camera_id = i % 4, .number = i, .times = {.t_capture_s = 1e9 + 0.01 * i}},
                      robots, balls, 1e9 + 0.01 * i, packet);
    }
    const auto payload = serialize(packet, buffer);
    // Some messages are from a tracker.
    const std::int32_t type = i % 5 == 3 ? LoggedMessage::kTracker2020 : LoggedMessage::kVision2014;
    out.add(1'000'000'000LL * i, type, payload);
  }
  out.finish();
  Counts counts;
  read_log(folder.path() / "our.log.gz", counts);
  EXPECT_EQ(counts.packets, 40);
  EXPECT_EQ(counts.detections, 35);
  EXPECT_EQ(counts.geometries, 5);
}

}  // namespace
}  // namespace sslv::log_packets_test
