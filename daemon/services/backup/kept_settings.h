// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/backup_part.h"
#include "services/settings/settings_editor.h"

#include <memory>
#include <string>
#include <utility>

namespace sslv {

/// Name of a backup's file with all settings; the state folder stores only changes of the settings.
inline constexpr const char* kSettingsName = "settings.json";

/// Returns the settings in effect with their history, and the Config that was read from them.
std::pair<KeptSettings, std::shared_ptr<const Config>> kept_settings(const SettingsEditor& settings);

std::string to_text(const KeptSettings& settings);
/// Throws SettingsError with a message that begins with the file's name.
KeptSettings read_kept_settings(const std::string& text);

/// Throws StorageError if `files` lack a table named in the settings: without it, the settings could not be
/// restored.
void check_has_tables(const Config& config, const BackupFiles& files);

// Human-readable summaries, as in docs/openapi.json.
/// [{"id": 0, "name": "..."}]. Entries that are not cameras are left out.
Json cameras_of(const Json& settings);
/// Number of tables, names of profiles, number of calibrations.
Json files_summary(const BackupFiles& files);

}  // namespace sslv
