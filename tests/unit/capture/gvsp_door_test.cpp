// SPDX-License-Identifier: Apache-2.0
#include "capture/aravis/gvsp_door.h"

#include "support/gvsp_packets.h"

#include <algorithm>
#include <cerrno>
#include <map>
#include <optional>
#include <utility>

#include <gtest/gtest.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>

namespace sslv::gvsp_door_test {
namespace {

using test::gvsp_extended_packet;
using test::gvsp_image_leader;
using test::gvsp_multipart_leader;
using test::gvsp_packet;
using test::gvsp_piece;
using test::GvspKind;

constexpr std::size_t kBuffer = 100'000, kPacket = 1500;
constexpr std::uint32_t kLoopback = INADDR_LOOPBACK;
// Packets per image with standard and extended headers: 1464 and 1452 bytes of it per packet.
constexpr std::uint32_t kStandardIds = (kBuffer + 1463) / 1464, kExtendedIds = (kBuffer + 1451) / 1452;

/// A filtered UDP socket, in some tests also a packet socket that receives the same packets.
class GvspDoor : public testing::Test {
 protected:
  GvspDoor() : udp_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(udp_, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
    socklen_t size = sizeof name;
    ::getsockname(udp_, reinterpret_cast<sockaddr*>(&name), &size);
    bounds_ = {kLoopback, kLoopback, ntohs(name.sin_port), kBuffer, kPacket};
  }
  ~GvspDoor() override {
    ::close(udp_);
    if (packet_ >= 0) ::close(packet_);
  }

  /// The data of the next UDP packet; nullopt if none arrives in time.
  std::optional<std::string> next() const {
    const int socket = packet_ >= 0 ? packet_ : udp_;
    const std::size_t headers = packet_ >= 0 ? ETH_HLEN + 28 : 0;
    const timeval patience{test::kPatience.count(), 0};
    ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    std::string bytes(65536, '\0');
    const ssize_t size = ::recv(socket, bytes.data(), bytes.size(), 0);
    if (size < 0) return std::nullopt;
    bytes.resize(static_cast<std::size_t>(size));
    return bytes.substr(std::min(bytes.size(), headers));
  }
  /// Whether the filter passes `packet`. A valid packet is sent after it to end the wait.
  bool passes(const std::string& packet, const test::UdpForger& from) {
    const std::string last = gvsp_packet(GvspKind::kTrailer, ++frame_, 1);
    from.send(bounds_.port, packet);
    camera_.send(bounds_.port, last);
    bool passed = false;
    for (;;) {
      const auto got = next();
      if (!got) ADD_FAILURE() << "nothing comes";
      if (!got || *got == last) return passed;
      passed = true;
    }
  }
  bool passes(const std::string& packet) { return passes(packet, camera_); }

  /// Checks which packets pass the filter.
  void expect_what_fits() {
    const auto leader = [](const std::string& data) { return gvsp_packet(GvspKind::kLeader, 1, 0, data); };
    const auto extended = [](const std::string& data, std::uint8_t parts = 0) {
      return gvsp_extended_packet(GvspKind::kLeader, 1, 0, data, parts);
    };
    const auto refused = [](std::string packet) {  // GEV_STATUS_PACKET_UNAVAILABLE
      return packet.replace(0, 2, "\x80\x0c");
    };
    const std::string image = gvsp_image_leader(320, 240), block(1464, 'x'), piece = gvsp_piece(0, "x");
    const std::map<std::string, std::string> good{
        {"leader", leader(image)},
        {"leader of what the library does not know", leader(gvsp_image_leader(1, 1, 0, 6))},
        {"leader with chunks", leader(gvsp_image_leader(1, 1, 0, test::kGvspImage | test::kGvspWithChunks))},
        {"extended leader", extended(image)},
        {"one part", extended(gvsp_multipart_leader({{10, 10, kBuffer}}), 1)},
        {"four parts",
         extended(gvsp_multipart_leader({{1, 1, 1}, {1, 1, kBuffer}, {1, 1, 0}, {1, 1, 1}}), 4)},
        {"first packet", gvsp_packet(GvspKind::kPayload, 1, 1, block)},
        {"last packet", gvsp_packet(GvspKind::kPayload, 1, kStandardIds, "x")},
        {"last extended packet", gvsp_extended_packet(GvspKind::kPayload, 1, kExtendedIds, "x")},
        {"trailer", gvsp_packet(GvspKind::kTrailer, 1, kStandardIds + 1, std::string(8, '\0'))},
        {"early trailer", gvsp_packet(GvspKind::kTrailer, 1, 1)},
        {"extended trailer", gvsp_extended_packet(GvspKind::kTrailer, 1, kExtendedIds + 1)},
        {"piece", gvsp_extended_packet(GvspKind::kMultipart, 1, kExtendedIds, piece)},
        {"packet that is gone", refused(gvsp_packet(GvspKind::kPayload, 1, kStandardIds))},
        {"extended packet that is gone", refused(gvsp_extended_packet(GvspKind::kPayload, 1, kExtendedIds))},
        {"piece that is gone", refused(gvsp_extended_packet(GvspKind::kMultipart, 1, 1))},
        {"trailer that is gone", refused(gvsp_packet(GvspKind::kTrailer, 1, 1))},
    };
    for (const auto& [what, packet] : good) EXPECT_TRUE(passes(packet)) << what;

    const std::map<std::string, std::string> bad{
        {"nothing", ""},
        {"less than a header", gvsp_packet(GvspKind::kPayload, 1, 1).substr(0, 7)},
        {"less than an extended header", gvsp_extended_packet(GvspKind::kPayload, 1, 1).substr(0, 19)},
        {"leader without a picture", leader(image.substr(0, 35))},
        {"leader with a number", gvsp_packet(GvspKind::kLeader, 1, 1, image)},
        {"extended leader with a number", gvsp_extended_packet(GvspKind::kLeader, 1, 1, image)},
        {"no part", extended(gvsp_multipart_leader({}), 0)},
        {"parts that are not there", extended(gvsp_multipart_leader({{1, 1, 1}}), 2)},
        {"five parts", extended(gvsp_multipart_leader(std::vector<test::GvspPart>(5, {1, 1, 1})), 5)},
        {"255 parts", extended(gvsp_multipart_leader(std::vector<test::GvspPart>(29, {1, 1, 1})), 255)},
        {"a part beyond the buffer", extended(gvsp_multipart_leader({{1, 1, kBuffer + 1}}), 1)},
        {"a second part beyond it", extended(gvsp_multipart_leader({{1, 1, 1}, {1, 1, kBuffer + 1}}), 2)},
        {"a part of 4 GiB", extended(gvsp_multipart_leader({{1, 1, std::uint64_t{1} << 32}}), 1)},
        {"parts with a standard header", leader(gvsp_multipart_leader({{1, 1, 1}}))},
        {"packet 0", gvsp_packet(GvspKind::kPayload, 1, 0, "x")},
        {"packet beyond the buffer", gvsp_packet(GvspKind::kPayload, 1, kStandardIds + 1, "x")},
        {"packet far beyond it", gvsp_packet(GvspKind::kPayload, 1, 0xffffff, "x")},
        {"extended packet beyond it", gvsp_extended_packet(GvspKind::kPayload, 1, kExtendedIds + 1, "x")},
        {"empty packet", gvsp_packet(GvspKind::kPayload, 1, 1)},
        {"larger packet than agreed", gvsp_packet(GvspKind::kPayload, 1, 1, block + "x")},
        {"trailer 0", gvsp_packet(GvspKind::kTrailer, 1, 0)},
        {"trailer that wants memory", gvsp_packet(GvspKind::kTrailer, 1, 0xffffff)},
        {"trailer that wants all memory", gvsp_extended_packet(GvspKind::kTrailer, 1, 0xfffffffe)},
        {"piece of nothing", gvsp_extended_packet(GvspKind::kMultipart, 1, 1, gvsp_piece(0, ""))},
        {"piece with a standard header", gvsp_packet(GvspKind::kMultipart, 1, 1, piece)},
        {"piece with a large number",
         gvsp_extended_packet(GvspKind::kMultipart, 1, 10 * kExtendedIds, piece)},
        {"leader that is gone", refused(gvsp_packet(GvspKind::kLeader, 1, 0))},
        {"packet 0 that is gone", refused(gvsp_packet(GvspKind::kPayload, 1, 0))},
        {"gone packet beyond the buffer", refused(gvsp_packet(GvspKind::kPayload, 1, kStandardIds + 1))},
        {"gone piece with a large number",
         refused(gvsp_extended_packet(GvspKind::kMultipart, 1, 10 * kExtendedIds))},
        {"less than the header of a gone packet",
         refused(gvsp_extended_packet(GvspKind::kPayload, 1, 1)).substr(0, 19)},
        {"all in one", gvsp_packet(GvspKind::kAllIn, 1, 1, image)},
        {"of a kind that there is not", gvsp_packet(static_cast<GvspKind>(77), 1, 1, image)},
    };
    for (const auto& [what, packet] : bad) EXPECT_FALSE(passes(packet)) << what;
    EXPECT_FALSE(passes(leader(image), stranger_)) << "from another address";
  }

  const int udp_;
  int packet_ = -1;
  std::uint16_t frame_ = 1;
  GvspBounds bounds_;
  const test::UdpForger camera_, stranger_{"127.0.0.2"};
};

TEST_F(GvspDoor, PassesFittingPacketsToAUdpSocket) {
  ASSERT_EQ(guard_gvsp_sockets(bounds_), 1);
  expect_what_fits();
  EXPECT_EQ(guard_gvsp_sockets(bounds_), 1) << "again";
  bounds_.port ^= 1;
  EXPECT_EQ(guard_gvsp_sockets(bounds_), 0) << "of another port";
}

TEST_F(GvspDoor, PassesFittingPacketsToAPacketSocket) {
  packet_ = ::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, htons(ETH_P_IP));
  if (packet_ < 0 && errno == EPERM) GTEST_SKIP() << "no right to open packet sockets";
  ASSERT_GE(packet_, 0);
  sockaddr_ll name{};
  name.sll_family = AF_PACKET;
  name.sll_protocol = htons(ETH_P_IP);
  name.sll_ifindex = static_cast<int>(::if_nametoindex("lo"));
  ASSERT_EQ(::bind(packet_, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  // A filter like the library's, by which guard_gvsp_sockets() recognises its socket.
  const sock_filter known[] = {BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kLoopback, 0, 0),
                               BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, bounds_.port, 0, 0),
                               BPF_STMT(BPF_RET | BPF_K, 0)};
  sock_fprog program{3, const_cast<sock_filter*>(known)};
  ASSERT_EQ(::setsockopt(packet_, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program), 0);
  ASSERT_EQ(guard_gvsp_sockets(bounds_), 2);
  expect_what_fits();
  EXPECT_EQ(guard_gvsp_sockets(bounds_), 2) << "again";
}

TEST_F(GvspDoor, IsShutWhereNoImageFits) {
  for (const auto& [buffer, packet] :
       {std::pair<std::size_t, std::size_t>{0, 1500}, {1000, 0}, {1000, 30}, {1000, 36}}) {
    GvspBounds none = bounds_;
    none.buffer_bytes = buffer;
    none.packet_bytes = packet;
    for (const GvspFilter& filter : {gvsp_udp_filter(none), gvsp_packet_filter(none)}) {
      ASSERT_FALSE(filter.empty());
      EXPECT_EQ(filter.back().k, 0U);
      EXPECT_EQ(filter.back().code, BPF_RET | BPF_K);
    }
  }
}

}  // namespace
}  // namespace sslv::gvsp_door_test
