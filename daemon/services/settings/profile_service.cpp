// SPDX-License-Identifier: Apache-2.0
#include "services/settings/profile_service.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "config/config.h"
#include "services/settings/settings_routes.h"
#include "settings/history.h"

#include <optional>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

Json entry_json(const Profile& profile) {
  return {{"name", profile.name}, {"time", profile.time_s}, {"who", profile.who}};
}

[[noreturn]] void refuse_unknown(const std::string& name) {
  throw HttpError(404, "no profile " + to_text(name));
}

/// Converts the profile to this program's settings version: an older or newer program may have saved it.
Json complete_settings_of(const Profile& profile) {
  try {
    Json tree = profile.settings;
    tree[kVersionKey] = profile.version;
    return complete_settings(up_to_date(std::move(tree), settings_migrations()));
  } catch (const SettingsError& error) {
    throw SettingsError(fmt::format("profile {}: {}", to_text(profile.name), error.what()));
  }
}

/// Throws SettingsError for a path that exists in neither tree.
void check_paths(const std::vector<std::string>& paths, const Json& before, const Json& after) {
  for (const std::string& path : paths) {
    bool is_place = false;
    try {
      const Json::json_pointer pointer(path);
      is_place = before.contains(pointer) || after.contains(pointer);
    } catch (const Json::exception&) {  // not a JSON Pointer
    }
    if (!is_place) {
      throw SettingsError(fmt::format(
          "paths: {} is not allowed; expected the JSON Pointer of a place in the settings", to_text(path)));
    }
  }
}

/// Returns member `key` of the body, which may have no other member; nothing if the body is empty. Throws
/// HttpError 400.
std::optional<Json> only_member(const Request& request, const char* key, const char* expected) {
  const Json body = body_json(request);
  if (body.is_object() && body.empty()) return std::nullopt;
  if (!body.is_object() || body.size() != 1 || !body.contains(key)) throw HttpError(400, expected);
  return body.at(key);
}

std::optional<std::vector<std::string>> read_paths(const std::optional<Json>& json) {
  if (!json) return std::nullopt;
  std::vector<std::string> paths;
  const auto refuse = [] { throw HttpError(400, "paths: expected a list of JSON Pointers"); };
  if (!json->is_array()) refuse();
  for (const Json& path : *json) {
    if (!path.is_string()) refuse();
    paths.push_back(path.get<std::string>());
  }
  return paths;
}

}  // namespace

Profile ProfileService::find(const std::string& name) const {
  auto found = profiles_.find(name);
  if (!found) refuse_unknown(name);
  return *std::move(found);
}

Json ProfileService::list() const {
  Json out = Json::array();
  for (const Profile& profile : profiles_.all()) out.push_back(entry_json(profile));
  return {{"profiles", std::move(out)}};
}

std::vector<Route> ProfileService::routes() {
  const auto call = [this](Response (ProfileService::*handle)(const Request&)) -> Handler {
    return [this, handle](const Request& request) { return (this->*handle)(request); };
  };
  return {
      {"GET", "/api/profiles", [this](const Request&) { return json_response(list()); }},
      {"POST", R"(/api/profiles/(.+)/apply)", call(&ProfileService::apply)},
      {"GET", R"(/api/profiles/(.+))", call(&ProfileService::get)},
      {"PUT", R"(/api/profiles/(.+))", call(&ProfileService::save)},
      {"DELETE", R"(/api/profiles/(.+))", call(&ProfileService::remove)},
  };
}

Response ProfileService::get(const Request& request) {
  const Profile found = find(request.matches[1]);
  Json out = entry_json(found);
  out["settings"] = found.settings;
  out["changes"] = changes_between(settings_.current().settings, complete_settings_of(found));
  return json_response(out);
}

Response ProfileService::save(const Request& request) {
  const auto settings =
      only_member(request, "settings", R"(expected {"settings": {...}}, or nothing for the current ones)");
  const Profile profile{request.matches[1], unix_time_s(), request.address,
                        settings ? check_any_version(*settings, settings_migrations(), complete_settings)
                                 : settings_.current().settings,
                        newest_version(settings_migrations())};
  profiles_.save(profile);
  log::info("profile {} saved by {}", to_text(profile.name), request.address);
  return json_response(entry_json(profile));
}

Response ProfileService::apply(const Request& request) {
  const auto paths =
      read_paths(only_member(request, "paths", R"(expected {"paths": [...]}, or nothing for all changes)"));
  const auto if_revision = if_match_of(request);
  const std::string& name = request.matches[1];
  const Json wanted = complete_settings_of(find(name));
  SettingsStore::Version version = settings_.current();
  Json changes = changes_between(version.settings, wanted);
  if (paths) {
    check_paths(*paths, version.settings, wanted);
    changes = changes_below(changes, *paths);
  }
  if (!changes.empty() || if_revision.value_or(version.revision) != version.revision) {
    // The changes were computed for exactly this revision.
    version = settings_.patch(
        forward_patch(changes),
        {request.address, if_revision.value_or(version.revision), fmt::format("profile {}", name)});
    log::info("settings revision {} saved, profile {} applied by {}", version.revision, to_text(name),
              request.address);
  }
  return json_response(saved_json(version));
}

Response ProfileService::remove(const Request& request) {
  const std::string& name = request.matches[1];
  if (!profiles_.remove(name)) refuse_unknown(name);
  log::info("profile {} deleted", to_text(name));
  return json_response(list());
}

}  // namespace sslv
