// SPDX-License-Identifier: Apache-2.0
// Settings that are kept under a name: docs/api.md.
#include "base/clock.h"
#include "base/log.h"
#include "daemon.h"
#include "settings/history.h"
#include "web/http.h"

#include <algorithm>

#include <fmt/format.h>

namespace sslv {
namespace {

Json entry_json(const Profile& profile) {
  return {{"name", profile.name}, {"time", profile.time_s}, {"who", profile.who}};
}

Json list_json(const std::vector<Profile>& profiles) {
  Json out = Json::array();
  for (const Profile& profile : profiles) out.push_back(entry_json(profile));
  return out;
}

[[noreturn]] void refuse_unknown(const std::string& name) {
  throw HttpError(404, "no profile " + to_text(name));
}

/// It may be older than this program, and newer.
Json complete_settings_of(const Profile& profile) {
  try {
    Json tree = profile.settings;
    tree[kVersionKey] = profile.version;
    return complete_settings(up_to_date(std::move(tree), settings_migrations()));
  } catch (const SettingsError& error) {
    throw SettingsError(fmt::format("profile {}: {}", to_text(profile.name), error.what()));
  }
}

/// Throws SettingsError for what is no place of either tree.
void check_paths(const std::vector<std::string>& paths, const Json& before, const Json& after) {
  for (const std::string& path : paths) {
    bool is_place = false;
    try {
      const Json::json_pointer pointer(path);
      is_place = before.contains(pointer) || after.contains(pointer);
    } catch (const Json::exception&) {  // no JSON Pointer
    }
    if (!is_place) {
      throw SettingsError(fmt::format(
          "paths: {} is not allowed; expected the JSON Pointer of a place in the settings", to_text(path)));
    }
  }
}

}  // namespace

Profile Daemon::profile(const std::string& name) const {
  auto found = profiles_.find(name);
  if (!found) refuse_unknown(name);
  return *std::move(found);
}

Json Daemon::profile_json(const std::string& name) const {
  const Profile found = profile(name);
  Json out = entry_json(found);
  out["settings"] = found.settings;
  out["changes"] = changes_between(store_.current().settings, complete_settings_of(found));
  return out;
}

Json Daemon::apply_profile(const std::string& name, const std::optional<std::vector<std::string>>& paths,
                           std::optional<std::uint64_t> if_revision, const std::string& who) {
  const Json wanted = complete_settings_of(profile(name));
  SettingsStore::Version version = store_.current();
  Json changes = changes_between(version.settings, wanted);
  if (paths) {
    check_paths(*paths, version.settings, wanted);
    changes = changes_below(changes, *paths);
  }
  if (!changes.empty() || if_revision.value_or(version.revision) != version.revision) {
    const std::string what = fmt::format("profile {}", name);
    // The changes are those of this very revision.
    version = store_.patch(forward_patch(changes), {who, if_revision.value_or(version.revision), what},
                           [this](const Json& next) { return prepare(next); });
    log::info("settings revision {} saved, profile {} applied by {}", version.revision, to_text(name), who);
  }
  return {{"revision", version.revision}, {"settings", version.settings}, {"saved", true}};
}

void Daemon::add_profiles_to(WebHost& host) {
  host.profiles = [this] { return list_json(profiles_.all()); };
  host.profile = [this](const std::string& name) { return profile_json(name); };
  host.save_profile = [this](const std::string& name, const std::optional<Json>& settings,
                             const std::string& who) {
    const Profile profile{name, unix_time_s(), who,
                          settings ? complete_settings(*settings) : store_.current().settings,
                          newest_version(settings_migrations())};
    profiles_.save(profile);
    log::info("profile {} saved by {}", to_text(name), who);
    return entry_json(profile);
  };
  host.apply_profile = [this](const std::string& name, const std::optional<std::vector<std::string>>& paths,
                              std::optional<std::uint64_t> if_revision, const std::string& who) {
    return apply_profile(name, paths, if_revision, who);
  };
  host.delete_profile = [this](const std::string& name) {
    if (!profiles_.remove(name)) refuse_unknown(name);
    log::info("profile {} deleted", to_text(name));
    return list_json(profiles_.all());
  };
}

}  // namespace sslv
