// SPDX-License-Identifier: Apache-2.0
#include "services/backup/kept_settings.h"

#include "base/error.h"
#include "config/config.h"
#include "settings/history.h"
#include "settings/profiles.h"

#include <algorithm>
#include <cstdint>
#include <exception>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr double kMaxRevision = 1e12;

}  // namespace

std::pair<KeptSettings, std::shared_ptr<const Config>> kept_settings(const SettingsEditor& settings) {
  for (;;) {
    SettingsStore::Version version = settings.current();
    Json history = settings.history();
    if (settings.current().revision != version.revision) continue;  // changed in between
    return {{std::move(version.settings), version.revision, std::move(history)}, version.config};
  }
}

std::string to_text(const KeptSettings& settings) {
  return json_text(Json{{kVersionKey, newest_version(settings_migrations())},
                        {"revision", settings.revision},
                        {"settings", settings.tree},
                        {"history", settings.history}},
                   2) +
         "\n";
}

KeptSettings read_kept_settings(const std::string& text) {
  const auto refuse = [](const std::string& why) {
    throw SettingsError(fmt::format("{}: {}", kSettingsName, why));
  };
  // Lower than for other JSON: settings are copied twice during validation.
  constexpr std::size_t kMaxBytes = 8 * 1024 * 1024;
  KeptSettings out;
  try {
    Json json = parse_bounded_json(text, kMaxBytes);
    version_of(json, settings_migrations());
    const bool is_good = json.is_object() && json.size() == 4 && json.contains(kVersionKey) &&
                         json.contains("revision") && json.contains("settings") && json.contains("history");
    if (!is_good) throw SettingsError("expected an object with version, revision, settings and history");
    if (!json["revision"].is_number_unsigned() || json["revision"].get<double>() > kMaxRevision)
      throw SettingsError("/revision: is not allowed; expected a whole number 0 .. 1000000000000");
    if (!json["settings"].is_object())
      throw SettingsError("/settings: is not allowed; expected all settings");
    const auto revision = json["revision"].get<std::uint64_t>();
    check_steps(json["history"], revision);
    out = {std::move(json["settings"]), revision, std::move(json["history"])};
    out.tree[std::string(kVersionKey)] = json[std::string(kVersionKey)];
  } catch (const std::exception& error) {
    refuse(error.what());
  }
  return out;
}

void check_has_tables(const Config& config, const BackupFiles& files) {
  for (std::size_t i = 0; i < config.cameras.size(); ++i) {
    const std::string& name = config.cameras[i].colors.table;
    const std::string file = fmt::format("tables/{}.lut", name);
    if (name.empty() || files.contains(file)) continue;
    throw StorageError(
        fmt::format("/cameras/{}/colors/table: the state folder's {} is missing or damaged, and settings "
                    "that name it could "
                    "not be restored; learn the colours again, or import a table, on the Colours page first",
                    i, file));
  }
}

Json cameras_of(const Json& settings) {
  Json out = Json::array();
  for (const Json& camera : settings.value("cameras", Json::array())) {
    if (!camera.is_object()) continue;
    const Json id = camera.value("id", Json(0)), name = camera.value("name", Json(""));
    if (id.is_number_integer() && name.is_string()) out.push_back({{"id", id}, {"name", name}});
  }
  return out;
}

Json files_summary(const BackupFiles& files) {
  Json profiles = Json::array();
  std::size_t calibrations = 0;
  if (const auto found = files.find(Profiles::kFileName); found != files.end()) {
    for (const Profile& profile : Profiles::from_text(found->second)) profiles.push_back(profile.name);
  }
  if (const auto found = files.find("calibrations.json"); found != files.end()) {
    Json json;
    try {
      json = parse_bounded_json(found->second);
    } catch (const std::exception& error) {
      throw SettingsError(fmt::format("calibrations.json: {}", error.what()));
    }
    if (json.is_object() && json.contains("cameras") && json["cameras"].is_array()) {
      for (const Json& camera : json["cameras"]) {
        if (camera.is_object() && camera.contains("records")) calibrations += camera["records"].size();
      }
    }
  }
  const auto tables = std::count_if(files.begin(), files.end(),
                                    [](const auto& file) { return file.first.starts_with("tables/"); });
  return {{"tables", tables}, {"profiles", std::move(profiles)}, {"calibrations", calibrations}};
}

}  // namespace sslv
