// SPDX-License-Identifier: Apache-2.0
//
// The league's messages against packets that real programs sent in a real match.
#include "ssl_vision_wrapper.pb.h"
#include "support/test_data.h"

#include <cstdint>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace sslv {
namespace {

template <class Integer>
bool read_big_endian(std::istream& in, Integer& value) {
  value = 0;
  for (std::size_t i = 0; i < sizeof value; ++i) {
    const int byte = in.get();
    if (byte < 0) return false;
    value = static_cast<Integer>(value << 8 | static_cast<Integer>(byte));
  }
  return true;
}

TEST(VisionLog, EveryPacketOfARealMatchReadsAndWritesBackTheSame) {
  constexpr std::uint32_t kVision2014 = 4;
  const auto path = test_data_folder() / "logs/roboime_larc2016_cyrosxfei2.log";
  std::ifstream in(path, std::ios::binary);
  if (!in) GTEST_SKIP() << "no recorded match at " << path;
  std::string magic(12, '\0');
  std::uint32_t version = 0;
  in.read(magic.data(), 12);
  ASSERT_TRUE(read_big_endian(in, version));
  ASSERT_EQ(magic, "SSL_LOG_FILE");
  ASSERT_EQ(version, 1U);

  int packets = 0, detections = 0, geometries = 0;
  std::uint64_t time_ns = 0;
  std::uint32_t type = 0, size = 0;
  while (read_big_endian(in, time_ns) && read_big_endian(in, type) && read_big_endian(in, size)) {
    std::string payload(size, '\0');
    ASSERT_TRUE(in.read(payload.data(), size));
    if (type != kVision2014) continue;
    SSL_WrapperPacket packet;
    ASSERT_TRUE(packet.ParseFromString(payload)) << "packet " << packets;
    // The same bytes again: no field was unknown to us or of another type.
    ASSERT_EQ(packet.SerializeAsString(), payload) << "packet " << packets;
    EXPECT_TRUE(packet.GetReflection()->GetUnknownFields(packet).empty());
    ++packets;
    detections += packet.has_detection();
    geometries += packet.has_geometry();
  }
  EXPECT_EQ(packets, 7992);
  EXPECT_EQ(detections + geometries, packets);
  EXPECT_GT(geometries, 0);
}

}  // namespace
}  // namespace sslv
