// SPDX-License-Identifier: Apache-2.0
//
// The league's messages against packets that real programs sent in a real match, and against our own.
#include "net/vision_log.h"

#include "base/error.h"
#include "net/packets.h"
#include "ssl_vision_wrapper.pb.h"
#include "support/test_data.h"

#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace sslv {
namespace {

template <class Integer>
void write_big_endian(std::ostream& out, Integer value) {
  for (std::size_t i = sizeof value; i-- > 0;) out.put(static_cast<char>(value >> (8 * i) & 0xFF));
}

constexpr std::uint32_t kVision2014 = 4;

struct Counts {
  int packets = 0, detections = 0, geometries = 0;
};

/// Reads a log of the league's logger; every packet must be written back as the same bytes: no field was
/// unknown to us or of another type.
void read_log(std::istream& in, Counts& counts) {
  VisionLogReader reader(in, "the log");
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

TEST(VisionLog, EveryPacketOfARealMatchReadsAndWritesBackTheSame) {
  const auto path = test_data_folder() / "logs/roboime_larc2016_cyrosxfei2.log";
  std::ifstream in(path, std::ios::binary);
  if (!in) GTEST_SKIP() << "no recorded match at " << path;
  Counts counts;
  read_log(in, counts);
  EXPECT_EQ(counts.packets, 7992);
  EXPECT_EQ(counts.detections + counts.geometries, counts.packets);
  EXPECT_GT(counts.geometries, 0);
}

// What we send ourselves, logged as the league's logger does it: the same is tried where there is no
// recording.
TEST(VisionLog, EveryPacketOfOursReadsAndWritesBackTheSame) {
  CameraCalibration calibration;
  calibration.focal_length = 600;
  calibration.tz = 3500;
  std::ostringstream out;
  out << "SSL_LOG_FILE";
  write_big_endian(out, std::uint32_t{1});
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
    write_big_endian(out, std::uint64_t{1'000'000'000} * i);
    write_big_endian(out, i % 5 == 3 ? kVision2014 + 1 : kVision2014);  // some are of other senders
    write_big_endian(out, static_cast<std::uint32_t>(payload.size()));
    out.write(reinterpret_cast<const char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
  }
  std::istringstream in(out.str());
  Counts counts;
  read_log(in, counts);
  EXPECT_EQ(counts.packets, 40);
  EXPECT_EQ(counts.detections, 35);
  EXPECT_EQ(counts.geometries, 5);
}

std::string error_of_log(const std::string& content) {
  std::istringstream in(content);
  try {
    VisionLogReader reader(in, "match.log");
    LoggedMessage message;
    while (reader.next(message)) {
    }
  } catch (const StorageError& error) {
    return error.what();
  }
  return "";
}

TEST(VisionLog, SaysWhatIsWrongWithALogInOneLine) {
  std::ostringstream out;
  out << "SSL_LOG_FILE";
  write_big_endian(out, std::uint32_t{1});
  const std::string head = out.str();
  EXPECT_EQ(error_of_log(head), "");
  EXPECT_EQ(error_of_log("RIFF....WAVE"),
            "match.log: is no log of the league: it does not begin with SSL_LOG_FILE");
  EXPECT_EQ(error_of_log(std::string("SSL_LOG_FILE\0\0\0\2", 16)),
            "match.log: version 2 of logs is not known; expected 1");
  write_big_endian(out, std::uint64_t{5});
  write_big_endian(out, kVision2014);
  EXPECT_EQ(error_of_log(out.str()), "match.log: message 1 is cut off");
  write_big_endian(out, std::uint32_t{10});
  EXPECT_EQ(error_of_log(out.str() + "short"), "match.log: message 1 is cut off");
  EXPECT_EQ(error_of_log(out.str() + "0123456789"), "");
}

}  // namespace
}  // namespace sslv
