// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <boost/asio/ip/address_v4.hpp>

namespace sslv {

/// A UDP socket of this computer that packets to a group and port are given to.
struct ListeningSocket {
  std::string address;  // that it is bound to: the group, "0.0.0.0" or "::"
  std::uint32_t user_id = 0;
  std::uint64_t inode = 0;
};

/// How a network card takes part in a group.
struct GroupMembership {
  std::string interface;
  unsigned joins = 0;    // by sockets of this computer, this service's own among them
  int igmp_version = 0;  // that the system uses on this card; 0: it does not say
};

/// From the text of /proc/net/udp or /proc/net/udp6: sockets at the port that are bound to the group or to
/// all addresses.
std::vector<ListeningSocket> listening_sockets(std::string_view proc_net_udp,
                                               const boost::asio::ip::address_v4& group, int port);

/// From the text of /proc/net/igmp.
std::vector<GroupMembership> group_memberships(std::string_view proc_net_igmp,
                                               const boost::asio::ip::address_v4& group);

/// What can be known of who listens to a group. Other computers cannot: multicast has no list of receivers.
struct LocalListeners {
  std::vector<ListeningSocket> others;  // sockets of other programs
  std::vector<GroupMembership> memberships;
};

/// Reads /proc; programs in containers with a network of their own are not in it.
LocalListeners local_listeners(const boost::asio::ip::address_v4& group, int port);

/// A user's name, or the number where the system knows none. May wait for the system's user database.
std::string user_name(std::uint32_t id);

}  // namespace sslv
