// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>  // before Asio of Boost 1.74, which uses std::exchange without it
#include <vector>

#include <boost/asio/ip/address_v4.hpp>

namespace sslv {

struct NetworkCard {
  std::string name;
  std::vector<boost::asio::ip::address_v4> addresses;  // those it has at present
  bool is_up = false;
  bool has_link = false;  // up, and its cable or access point is there
  bool is_loopback = false;
  bool has_multicast = false;                             // as the system says; lo says no and still takes it
  std::vector<boost::asio::ip::address_v4> broadcasts{};  // of its subnets
};

/// The network cards of this computer, in the system's order.
std::vector<NetworkCard> network_cards();

/// Those that have an IPv4 address, as the end of a sentence for the admin.
std::string network_cards_text();

/// The address that packets to `destination` leave from by the system's routes; 0.0.0.0: there is no way.
boost::asio::ip::address_v4 address_towards(const boost::asio::ip::address_v4& destination);

/// The address of the card with this name or IPv4 address. Throws std::runtime_error when there is none.
boost::asio::ip::address_v4 find_network_card(const std::string& name_or_address);
/// Likewise its name.
std::string network_card_name(const std::string& name_or_address);

/// Where broadcasts to a card go, or to all of them when `name_or_address` is empty: 255.255.255.255 and
/// those of its subnets.
std::vector<boost::asio::ip::address_v4> broadcast_addresses(const std::string& name_or_address);

/// Whether this may be a broadcast address, as far as it says itself: which those of subnets are, only their
/// computers know.
bool may_be_broadcast(const boost::asio::ip::address_v4& address);

}  // namespace sslv
