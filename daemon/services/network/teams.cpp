// SPDX-License-Identifier: Apache-2.0
#include "services/network/teams.h"

#include "net/team_heights.h"

namespace sslv {
namespace {

TeamNow team_now(const TeamSettings& settings, const std::string& referee_name, bool height_from_referee) {
  TeamNow team{referee_name.empty() ? settings.name : referee_name, settings.robot_height};
  if (!height_from_referee || referee_name.empty()) return team;
  if (const auto height_mm = team_height_mm(referee_name)) {
    team.robot_height_mm = *height_mm;
    team.height_is_known = true;
  } else {
    // If the settings have this team's name, they also have its height.
    team.name_is_unknown = !is_same_team(referee_name, settings.name);
  }
  return team;
}

}  // namespace

std::array<TeamNow, 2> teams_now(const TeamsSettings& settings,
                                 const std::array<std::string, 2>& referee_names) {
  return {team_now(settings.yellow, referee_names[0], settings.height_from_referee),
          team_now(settings.blue, referee_names[1], settings.height_from_referee)};
}

}  // namespace sslv
