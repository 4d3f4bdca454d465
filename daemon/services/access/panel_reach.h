// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "net/network_cards.h"

#include <cstdint>
#include <string>
#include <vector>

namespace sslv {

/// Addresses at which browsers find the panel.
struct PanelReach {
  std::uint16_t port = 0;
  std::vector<std::string> addresses{};  // http://..., for other computers; empty: only this computer

  bool operator==(const PanelReach&) const = default;
};

/// Returns the addresses of a server that listens on `listens_on` and `port`, on a computer with these
/// network cards.
PanelReach panel_reach(const std::string& listens_on, std::uint16_t port,
                       const std::vector<NetworkCard>& cards);

/// PanelReach of docs/openapi.json.
Json panel_reach_json(const PanelReach& reach);

}  // namespace sslv
