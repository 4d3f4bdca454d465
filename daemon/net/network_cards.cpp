// SPDX-License-Identifier: Apache-2.0
#include "net/network_cards.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string_view>

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
    const std::string_view label = entry->ifa_name;
    const std::string name(label.substr(0, label.find(':')));  // "eth0:1" is another address of eth0
    auto card =
        std::find_if(cards.begin(), cards.end(), [&](const NetworkCard& one) { return one.name == name; });
    if (card == cards.end()) {
      card = cards.insert(cards.end(), {.name = name,
                                        .addresses = {},
                                        .is_up = (entry->ifa_flags & IFF_UP) != 0,
                                        .has_link = (entry->ifa_flags & IFF_RUNNING) != 0,
                                        .is_loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0,
                                        .has_multicast = (entry->ifa_flags & IFF_MULTICAST) != 0});
    }
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    const auto number_of = [](const sockaddr* one) {
      return ntohl(reinterpret_cast<const sockaddr_in*>(one)->sin_addr.s_addr);
    };
    const std::uint32_t address = number_of(entry->ifa_addr);
    card->addresses.emplace_back(address);
    const std::uint32_t hosts = entry->ifa_netmask == nullptr ? 0 : ~number_of(entry->ifa_netmask);
    const address_v4 broadcast(address | hosts);
    if (broadcast != card->addresses.back() && may_be_broadcast(broadcast))
      card->broadcasts.push_back(broadcast);
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
  socket.set_option(udp::socket::broadcast(true), error);
  socket.connect({destination, kAnyPort}, error);  // sends nothing
  const udp::endpoint from = socket.local_endpoint(error);
  return from.address().is_v4() ? from.address().to_v4() : address_v4();
}

namespace {

/// Throws std::runtime_error if there is no such card.
std::pair<NetworkCard, address_v4> card_and_address(const std::string& name_or_address) {
  for (const NetworkCard& card : network_cards()) {
    for (const address_v4& address : card.addresses) {
      if (card.name == name_or_address || address.to_string() == name_or_address) return {card, address};
    }
  }
  throw std::runtime_error("no network card has the name or IPv4 address '" + name_or_address + "'");
}

}  // namespace

address_v4 find_network_card(const std::string& name_or_address) {
  return card_and_address(name_or_address).second;
}

std::string network_card_name(const std::string& name_or_address) {
  return card_and_address(name_or_address).first.name;
}

std::vector<address_v4> broadcast_addresses(const std::string& name_or_address) {
  std::vector<address_v4> out{address_v4::broadcast()};
  const std::vector<NetworkCard> cards = network_cards();
  for (const NetworkCard& card : cards) {
    const bool is_asked_for = name_or_address.empty() || card.name == name_or_address ||
                              std::ranges::any_of(card.addresses, [&](const address_v4& one) {
                                return one.to_string() == name_or_address;
                              });
    if (is_asked_for) out.insert(out.end(), card.broadcasts.begin(), card.broadcasts.end());
  }
  return out;
}

bool may_be_broadcast(const address_v4& address) {
  constexpr std::uint32_t kFirstClassA = 0x01000000, kSmallestSubnet = 3;  // four addresses
  return address == address_v4::broadcast() ||
         (address.to_uint() >= kFirstClassA && !address.is_multicast() && address.to_uint() < 0xE0000000 &&
          (address.to_uint() & kSmallestSubnet) == kSmallestSubnet);
}

}  // namespace sslv
