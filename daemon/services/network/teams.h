// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "config/config.h"

#include <array>
#include <string>

namespace sslv {

/// A team as it plays now.
struct TeamNow {
  std::string name;
  double robot_height_mm = 0;
  bool height_is_known = false;  // the height of this name; otherwise the one of the settings
  bool name_is_unknown = false;  // the game controller names a team of no known height, which
                                 // the settings do not name either
};

/// The settings and what the game controller says (empty: nothing) together; by Team, as the names.
std::array<TeamNow, 2> teams_now(const TeamsSettings& settings,
                                 const std::array<std::string, 2>& referee_names);

}  // namespace sslv
