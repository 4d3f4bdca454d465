// SPDX-License-Identifier: Apache-2.0
#include "net/local_listeners.h"

#include "support/group_listener.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <unistd.h>

namespace sslv::local_listeners_test {
namespace {

using boost::asio::ip::make_address_v4;
using testing::IsEmpty;
using testing::SizeIs;

const auto kVision = make_address_v4("224.5.23.2");

TEST(ListeningSockets, AreThoseThatGetTheGroupsPackets) {
  // In this order: the group, all addresses, one card's address, another port.
  const auto found = listening_sockets(
      "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode\n"
      "  10: 021705E0:2716 00000000:0000 07 00000000:00000000 00:00000000 00000000  1000        0 4711 2 0 "
      "0\n"
      "  11: 00000000:2716 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 4712 2 0 "
      "0\n"
      "  12: 0100007F:2716 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 4713 2 0 "
      "0\n"
      "  13: 021705E0:2717 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 4714 2 0 "
      "0\n",
      kVision, 10006);
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(found[0].address, "224.5.23.2");
  EXPECT_EQ(found[0].user_id, 1000U);
  EXPECT_EQ(found[0].inode, 4711U);
  EXPECT_EQ(found[1].address, "0.0.0.0");
  EXPECT_EQ(found[1].inode, 4712U);
}

TEST(ListeningSockets, IncludeIPv6SocketsThatReceiveIPv4) {
  const auto found = listening_sockets(
      "  sl  local_address                         remote_address                        st tx rx tr\n"
      "   1: 00000000000000000000000000000000:2716 00000000000000000000000000000000:0000 07 0:0 00:0 0 1000 "
      "0 1 2\n"
      "   2: 0000000000000000FFFF0000021705E0:2716 00000000000000000000000000000000:0000 07 0:0 00:0 0 1001 "
      "0 2 2\n"
      "   3: 000080FE00000000FF005450FEFFFF00:2716 00000000000000000000000000000000:0000 07 0:0 00:0 0 1002 "
      "0 3 2\n",
      kVision, 10006);
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(found[0].address, "::");
  EXPECT_EQ(found[1].address, "224.5.23.2");
  EXPECT_EQ(found[1].user_id, 1001U);
}

TEST(ListeningSockets, ReadsNothingFromOtherTexts) {
  EXPECT_THAT(listening_sockets("", kVision, 10006), IsEmpty());
  EXPECT_THAT(listening_sockets("a\nb c\n1: x:y 3\n", kVision, 10006), IsEmpty());
}

TEST(GroupMemberships, AreCountedForEachCard) {
  const auto found = group_memberships(
      "Idx\tDevice    : Count Querier\tGroup    Users Timer\tReporter\n"
      "1\tlo        :     1      V3\n"
      "\t\t\t\t010000E0     1 0:00000000\t\t0\n"
      "2\tenp0s31f6abc:     2      V2\n"
      "\t\t\t\t021705E0     3 0:00000000\t\t0\n"
      "\t\t\t\t010000E0     1 0:00000000\t\t0\n",
      kVision);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].interface, "enp0s31f6abc");
  EXPECT_EQ(found[0].joins, 3U);
  EXPECT_EQ(found[0].igmp_version, 2);
}

TEST(LocalListeners, LeaveOutThisProcessButSeeItsMembership) {
  const GroupListener listener;
  const auto found = local_listeners(make_address_v4(GroupListener::kGroup), listener.port());
  EXPECT_THAT(found.others, IsEmpty());
  ASSERT_THAT(found.memberships, SizeIs(1));
  EXPECT_EQ(found.memberships[0].interface, "lo");
  EXPECT_GE(found.memberships[0].joins, 1U);
}

TEST(UserName, IsTheNumberOfAUserThatIsNotKnown) {
  EXPECT_EQ(user_name(0), "root");
  EXPECT_EQ(user_name(3'999'999'999), "3999999999");
}

}  // namespace
}  // namespace sslv::local_listeners_test
