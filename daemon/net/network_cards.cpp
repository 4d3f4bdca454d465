// SPDX-License-Identifier: Apache-2.0
#include "net/network_cards.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

namespace sslv {

using boost::asio::ip::address_v4;

std::vector<NetworkCard> network_cards() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, &freeifaddrs);
  std::vector<NetworkCard> cards;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    auto card = std::find_if(cards.begin(), cards.end(),
                             [&](const NetworkCard& one) { return one.name == entry->ifa_name; });
    if (card == cards.end()) {
      card = cards.insert(cards.end(), {.name = entry->ifa_name,
                                        .addresses = {},
                                        .is_up = (entry->ifa_flags & IFF_UP) != 0,
                                        .has_link = (entry->ifa_flags & IFF_RUNNING) != 0,
                                        .is_loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0,
                                        .has_multicast = (entry->ifa_flags & IFF_MULTICAST) != 0});
    }
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    card->addresses.emplace_back(ntohl(address->sin_addr.s_addr));
  }
  return cards;
}

std::string network_cards_text() {
  std::string cards;
  for (const NetworkCard& card : network_cards()) {
    for (const address_v4& address : card.addresses)
      cards += " " + card.name + " (" + address.to_string() + ")";
  }
  return cards.empty() ? "no card has an IPv4 address at present" : "there are" + cards;
}

address_v4 address_towards(const address_v4& destination) {
  using boost::asio::ip::udp;
  constexpr std::uint16_t kAnyPort = 9;
  boost::asio::io_context io;
  udp::socket socket(io);
  boost::system::error_code error;
  socket.open(udp::v4(), error);
  socket.connect({destination, kAnyPort}, error);  // sends nothing
  const udp::endpoint from = socket.local_endpoint(error);
  return from.address().is_v4() ? from.address().to_v4() : address_v4();
}

address_v4 find_network_card(const std::string& name_or_address) {
  for (const NetworkCard& card : network_cards()) {
    for (const address_v4& address : card.addresses) {
      if (card.name == name_or_address || address.to_string() == name_or_address) return address;
    }
  }
  throw std::runtime_error("no network card has the name or IPv4 address '" + name_or_address + "'");
}

}  // namespace sslv
