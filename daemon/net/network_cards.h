// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>  // Asio of Boost 1.74 uses std::exchange without this include
#include <vector>

#include <boost/asio/ip/address_v4.hpp>

namespace sslv {

struct NetworkCard {
  std::string name;
  std::vector<boost::asio::ip::address_v4> addresses;  // its current IPv4 addresses
  bool is_up = false;
  bool has_link = false;  // up, and connected to a cable or access point
  bool is_loopback = false;
  /// As reported by the system, which reports false for lo, although lo accepts multicast.
  bool has_multicast = false;
  std::vector<boost::asio::ip::address_v4> broadcasts{};  // broadcast addresses of its subnets
};

/// The network cards of this computer, in the system's order.
std::vector<NetworkCard> network_cards();

/// The cards that have an IPv4 address, as the end of a sentence for the admin.
std::string network_cards_text();

/// The local address of packets to `destination` by the system's routes; 0.0.0.0 without a route.
boost::asio::ip::address_v4 address_towards(const boost::asio::ip::address_v4& destination);

/// The address of the card with this name or IPv4 address. Throws std::runtime_error if there is no such
/// card.
boost::asio::ip::address_v4 find_network_card(const std::string& name_or_address);
/// The name of the card with this name or IPv4 address. Throws like find_network_card().
std::string network_card_name(const std::string& name_or_address);

/// The broadcast addresses of a card, or of all cards if `name_or_address` is empty: 255.255.255.255 and the
/// broadcast addresses of the subnets.
std::vector<boost::asio::ip::address_v4> broadcast_addresses(const std::string& name_or_address);

/// Whether the address can be a broadcast address. A definite answer requires the subnet's mask, which only
/// the subnet's computers know.
bool may_be_broadcast(const boost::asio::ip::address_v4& address);

}  // namespace sslv
