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
  bool has_multicast = false;  // as the system says; lo says no and still takes it
};

/// The network cards of this computer, in the system's order.
std::vector<NetworkCard> network_cards();

/// Those that have an IPv4 address, as the end of a sentence for the admin.
std::string network_cards_text();

/// The address that packets to `destination` leave from by the system's routes; 0.0.0.0: there is no way.
boost::asio::ip::address_v4 address_towards(const boost::asio::ip::address_v4& destination);

/// The address of the card with this name or IPv4 address. Throws std::runtime_error when there is none.
boost::asio::ip::address_v4 find_network_card(const std::string& name_or_address);

}  // namespace sslv
