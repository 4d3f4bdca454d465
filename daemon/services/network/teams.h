// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"

#include <array>
#include <string>

namespace sslv {

/// A team in the current game.
struct TeamNow {
  std::string name;
  double robot_height_mm = 0;
  bool height_is_known = false;  // the height belongs to this name; otherwise it is from the settings
  bool name_is_unknown = false;  // neither a height table nor the settings have this name
};

/// Combines the settings with the game controller's names (empty: none). Both are indexed by Team.
std::array<TeamNow, 2> teams_now(const TeamsSettings& settings,
                                 const std::array<std::string, 2>& referee_names);

}  // namespace sslv
