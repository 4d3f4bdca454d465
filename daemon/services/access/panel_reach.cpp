// SPDX-License-Identifier: Apache-2.0
#include "services/access/panel_reach.h"

#include <boost/asio/ip/address.hpp>
#include <fmt/format.h>

namespace sslv {

PanelReach panel_reach(const std::string& listens_on, std::uint16_t port,
                       const std::vector<NetworkCard>& cards) {
  PanelReach reach{port};
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(listens_on, error);
  if (error || address.is_loopback()) return reach;
  if (!address.is_unspecified()) {
    const std::string host = address.is_v6() ? "[" + listens_on + "]" : listens_on;
    reach.addresses.push_back(fmt::format("http://{}:{}/", host, port));
    return reach;
  }
  for (const NetworkCard& card : cards) {
    if (!card.is_up || card.is_loopback) continue;
    for (const auto& one : card.addresses)
      reach.addresses.push_back(fmt::format("http://{}:{}/", one.to_string(), port));
  }
  return reach;
}

Json panel_reach_json(const PanelReach& reach) {
  return {{"port", reach.port}, {"addresses", reach.addresses}};
}

}  // namespace sslv
