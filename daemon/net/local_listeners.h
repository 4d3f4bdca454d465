// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/ip/address_v4.hpp>

namespace sslv {

/// A UDP or raw socket of this computer that receives packets to a group and port.
struct ListeningSocket {
  std::string address;  // bound address: the group, "0.0.0.0" or "::"
  std::uint32_t user_id = 0;
  std::uint64_t inode = 0;
};

/// A network card's membership in a group.
struct GroupMembership {
  std::string interface;
  unsigned joins = 0;    // number of sockets of this computer that joined, including this service's
  int igmp_version = 0;  // version that the system uses on this card; 0: unknown
};

/// Parses the text of /proc/net/udp or /proc/net/udp6. Returns the sockets at the port that are bound to the
/// group or to all addresses.
std::vector<ListeningSocket> listening_sockets(std::string_view proc_net_udp,
                                               const boost::asio::ip::address_v4& group, int port);

/// Parses the text of /proc/net/igmp.
std::vector<GroupMembership> group_memberships(std::string_view proc_net_igmp,
                                               const boost::asio::ip::address_v4& group);

/// The known listeners of a group on this computer. Other computers are unknown: multicast has no list of
/// receivers.
struct LocalListeners {
  std::vector<ListeningSocket> others;  // sockets of other programs
  std::vector<GroupMembership> memberships;
};

/// Reads /proc, which does not include containers with their own network.
LocalListeners local_listeners(const boost::asio::ip::address_v4& group, int port);

/// A user's name, or the number if the system knows no name. May wait for the system's user database.
std::string user_name(std::uint32_t id);

}  // namespace sslv
