// SPDX-License-Identifier: Apache-2.0
#include "services/access/panel_reach.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sslv::panel_reach_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

NetworkCard card_of(const char* name, const char* address, bool is_up = true, bool is_loopback = false) {
  return {.name = name,
          .addresses = {boost::asio::ip::make_address_v4(address)},
          .is_up = is_up,
          .is_loopback = is_loopback,
          .has_multicast = true};
}

const std::vector<NetworkCard> kReachCards{card_of("lo", "127.0.0.1", true, true),
                                           card_of("enp3s0", "192.168.1.10"), card_of("enp4s0", "10.0.0.5"),
                                           card_of("wlan0", "192.168.7.7", false)};

TEST(PanelReach, OnAllCardsListsThoseThatAreUp) {
  for (const char* all : {"0.0.0.0", "::"}) {
    EXPECT_THAT(panel_reach(all, 8090, kReachCards).addresses,
                ElementsAre("http://192.168.1.10:8090/", "http://10.0.0.5:8090/"));
  }
}

TEST(PanelReach, OnOneAddressListsOnlyThatOne) {
  EXPECT_THAT(panel_reach("10.0.0.5", 80, kReachCards).addresses, ElementsAre("http://10.0.0.5:80/"));
  EXPECT_THAT(panel_reach("2001:db8::1", 80, kReachCards).addresses, ElementsAre("http://[2001:db8::1]:80/"));
}

TEST(PanelReach, OnLoopbackListsNoAddress) {
  for (const char* own : {"127.0.0.1", "127.0.0.2", "::1"})
    EXPECT_THAT(panel_reach(own, 8090, kReachCards).addresses, IsEmpty());
  EXPECT_EQ(panel_reach("127.0.0.1", 8090, kReachCards).port, 8090);
  EXPECT_THAT(panel_reach("0.0.0.0", 8090, {}).addresses, IsEmpty());
}

}  // namespace
}  // namespace sslv::panel_reach_test
