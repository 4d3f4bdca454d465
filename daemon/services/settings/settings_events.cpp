// SPDX-License-Identifier: Apache-2.0
#include "services/settings/settings_events.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

/// The longest path that contains all places; empty: the whole tree.
std::string common_place(const std::vector<std::string>& places) {
  std::string common = places.front();
  for (const std::string& place : places) {
    while (!(place + '/').starts_with(common + '/')) common.erase(common.rfind('/'));
  }
  return common;
}

/// "/site, /field/field_length", or "/field (5 places)", or "/site, /field/field_length and 3 more".
std::string places_text(const Json& changes) {
  constexpr std::size_t kMaxNamed = 2;
  std::vector<std::string> places;
  for (const Json& change : changes) {
    const std::string path = change.at("path").get<std::string>();
    if (std::find(places.begin(), places.end(), path) == places.end()) places.push_back(path);
  }
  if (places.size() > kMaxNamed) {
    if (const std::string common = common_place(places); !common.empty())
      return fmt::format("{} ({} places)", common, places.size());
  }
  std::string out;
  for (std::size_t i = 0; i < std::min(places.size(), kMaxNamed); ++i)
    out += fmt::format("{}{}", i == 0 ? "" : ", ", places[i]);
  if (places.size() > kMaxNamed) out += fmt::format(" and {} more", places.size() - kMaxNamed);
  return out.empty() ? "nothing" : out;
}

}  // namespace

Event event_of(const SettingsStep& step) {
  const std::string what = step.at("what").get<std::string>();
  const std::string places = places_text(step.at("changes"));
  Event event{"settings_changed", "Settings changed: " + places, step.at("who").get<std::string>()};
  const auto is = [&](const char* prefix) { return what.starts_with(prefix); };
  if (is("calibration")) {
    event.id = "calibration_saved";
    event.title = fmt::format("C{}: {}", what.substr(1), places);
  } else if (is("colours")) {
    event.id = "colors_saved";
    event.title = "Colour table saved: " + places;
  } else if (is("profile ")) {
    event.id = "profile_applied";
    event.title = fmt::format("P{} applied: {}", what.substr(1), places);
  } else if (is("backup of ")) {
    event.id = "backup_restored";
    event.title = fmt::format("B{} restored: {}", what.substr(1), places);
  } else if (is("undo of ")) {
    event.id = "settings_undone";
    event.title = fmt::format("U{} of the settings: {}", what.substr(1), places);
  } else if (is("reload of ")) {
    event.id = "settings_reloaded";
    event.title = "Settings file reloaded: " + places;
  } else if (!what.empty()) {
    event.title = fmt::format("Settings changed, {}: {}", what, places);
  }
  return event;
}

}  // namespace sslv
