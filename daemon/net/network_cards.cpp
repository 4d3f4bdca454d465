// SPDX-License-Identifier: Apache-2.0
#include "net/network_cards.h"

#include <memory>
#include <stdexcept>

#include <ifaddrs.h>
#include <netinet/in.h>

namespace sslv {

using boost::asio::ip::address_v4;

std::vector<NetworkCard> network_cards() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, &freeifaddrs);
  std::vector<NetworkCard> cards;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    cards.push_back({entry->ifa_name, address_v4(ntohl(address->sin_addr.s_addr))});
  }
  return cards;
}

std::string network_cards_text() {
  std::string cards;
  for (const NetworkCard& card : network_cards())
    cards += " " + card.name + " (" + card.address.to_string() + ")";
  return cards.empty() ? "no card has an IPv4 address at present" : "there are" + cards;
}

address_v4 find_network_card(const std::string& name_or_address) {
  for (const NetworkCard& card : network_cards()) {
    if (card.name == name_or_address || card.address.to_string() == name_or_address) return card.address;
  }
  throw std::runtime_error("no network card has the name or IPv4 address '" + name_or_address + "'");
}

}  // namespace sslv
