// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "net/network_cards.h"

#include <cstdint>
#include <string>
#include <vector>

namespace sslv {

/// Where browsers find the panel.
struct PanelReach {
  std::uint16_t port = 0;
  std::vector<std::string> addresses{};  // http://..., for other computers; none: only this computer

  bool operator==(const PanelReach&) const = default;
};

/// What reaches a server that listens there, on a computer with these network cards.
PanelReach panel_reach(const std::string& listens_on, std::uint16_t port,
                       const std::vector<NetworkCard>& cards);

/// docs/openapi.json's PanelReach.
Json panel_reach_json(const PanelReach& reach);

}  // namespace sslv
