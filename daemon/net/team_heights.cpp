// SPDX-License-Identifier: Apache-2.0
#include "net/team_heights.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <glib.h>

namespace sslv {
namespace {

struct TeamHeight {
  std::string_view name;
  double height_mm;
};

constexpr TeamHeight kTeamHeights[] = {
    {"AIS", 150},
    {"CMμs", 140},
    {"DelftMercurians", 150},
    {"ER-Force", 148},
    {"GreenTea", 148},
    {"ibis", 90},
    {"Immortals", 150},
    {"ITAndroids", 141},
    {"KIKS", 148},
    {"luhbots", 138},
    {"MCT Susano Logics", 148},
    {"MRL", 150},
    {"NAMeC", 149},
    {"NEUIslanders", 140},
    {"N.R.G", 147},
    {"OP-AmP", 147},
    {"RobôCIn", 144},
    {"RobôCIn-B", 150},
    {"RoboDragons", 125},
    {"RoboFEI", 149},
    {"RoboIME", 149},
    {"RoboJackets", 150},
    {"Robocup Junior SSL Team", 180},
    {"RoboTeam Twente", 145},
    {"The Bots", 110},
    {"TIGERs Mannheim", 143},
    {"TurtleRabbit", 150},
    {"UBC Thunderbots", 144},
    {"ULtron", 143},
    {"UMass Minutebots", 150},
    {"ZJUNlict", 148.725},
};

using GText = std::unique_ptr<gchar, decltype(&g_free)>;

/// The name reduced to its letters and digits, without case and accents.
std::u32string key_of(std::string_view name) {
  const GText decomposed(g_utf8_normalize(name.data(), static_cast<gssize>(name.size()), G_NORMALIZE_ALL),
                         g_free);
  if (!decomposed) return {};  // not UTF-8
  const GText folded(g_utf8_casefold(decomposed.get(), -1), g_free);
  std::u32string key;
  for (const gchar* at = folded.get(); *at != '\0'; at = g_utf8_next_char(at)) {
    constexpr gunichar kMu = 0x3BC;
    const gunichar letter = g_utf8_get_char(at);
    // Users without mu on their keyboard type u.
    if (g_unichar_isalnum(letter)) key += letter == kMu ? U'u' : static_cast<char32_t>(letter);
  }
  return key;
}

}  // namespace

std::optional<double> team_height_mm(std::string_view name) {
  struct Known {
    std::u32string key;
    double height_mm;
  };
  static const std::vector<Known> kTeams = [] {
    std::vector<Known> keyed;
    for (const TeamHeight& team : kTeamHeights) keyed.push_back({key_of(team.name), team.height_mm});
    return keyed;
  }();
  const std::u32string key = key_of(name);
  const auto found =
      std::find_if(kTeams.begin(), kTeams.end(), [&](const Known& one) { return one.key == key; });
  return found == kTeams.end() ? std::nullopt : std::optional(found->height_mm);
}

bool is_same_team(std::string_view name, std::string_view other) {
  const std::u32string key = key_of(name);
  return name == other || (!key.empty() && key == key_of(other));
}

}  // namespace sslv
