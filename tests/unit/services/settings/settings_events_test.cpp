// SPDX-License-Identifier: Apache-2.0
#include "services/settings/settings_events.h"

#include <gtest/gtest.h>

namespace sslv::settings_events_test {
namespace {

Event event_with(const char* what, std::initializer_list<const char*> paths) {
  Json changes = Json::array();
  for (const char* path : paths) changes.push_back({{"op", "replace"}, {"path", path}});
  return event_of(
      {{"revision", 7}, {"time", 1.0}, {"who", "10.0.0.7"}, {"what", what}, {"changes", changes}});
}

TEST(SettingsEvents, SayWhatWasDoneWhereAndByWhom) {
  const struct {
    const char* what;
    const char* id;
    const char* title;
  } rows[] = {
      {"", "settings_changed", "Settings changed: /site"},
      {"calibration accepted", "calibration_saved", "Calibration accepted: /site"},
      {"colours", "colors_saved", "Colour table saved: /site"},
      {"profile Night", "profile_applied", "Profile Night applied: /site"},
      {"backup of Hall 2", "backup_restored", "Backup of Hall 2 restored: /site"},
      {"undo of revision 6", "settings_undone", "Undo of revision 6 of the settings: /site"},
      {"reload of /etc/a.json", "settings_reloaded", "Settings file reloaded: /site"},
      {"restored", "settings_changed", "Settings changed, restored: /site"},
  };
  for (const auto& row : rows) {
    const Event event = event_with(row.what, {"/site"});
    EXPECT_EQ(event.id, row.id);
    EXPECT_EQ(event.title, row.title);
    EXPECT_EQ(event.who, "10.0.0.7");
  }
}

TEST(SettingsEvents, NameFewPlaces) {
  EXPECT_EQ(event_with("", {"/a", "/a", "/b", "/c", "/d"}).title, "Settings changed: /a, /b and 2 more");
  EXPECT_EQ(event_with("", {"/f/a", "/f/b/c", "/f/b/d"}).title, "Settings changed: /f (3 places)");
  EXPECT_EQ(event_with("", {"/f/a", "/fa/b", "/f/c"}).title, "Settings changed: /f/a, /fa/b and 1 more");
  EXPECT_EQ(event_with("", {}).title, "Settings changed: nothing");
}

}  // namespace
}  // namespace sslv::settings_events_test
