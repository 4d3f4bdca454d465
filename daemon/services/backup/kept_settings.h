// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/backup_part.h"
#include "services/settings/settings_editor.h"

#include <memory>
#include <string>
#include <utility>

namespace sslv {

/// The name in a backup of the file with all settings, whole: in the state folder lie only changes.
inline constexpr const char* kSettingsName = "settings.json";

/// The settings in effect, with their history, and what was read from them.
std::pair<KeptSettings, std::shared_ptr<const Config>> kept_settings(const SettingsEditor& settings);

std::string to_text(const KeptSettings& settings);
/// Throws SettingsError, beginning with the file's name.
KeptSettings read_kept_settings(const std::string& text);

/// Settings whose tables are not there could not be restored. Throws StorageError.
void check_has_tables(const Config& config, const BackupFiles& files);

// For people, as docs/openapi.json has them:
/// [{"id": 0, "name": "..."}]. What is none is left out.
Json cameras_of(const Json& settings);
/// How many tables, which profiles, how many calibrations.
Json files_summary(const BackupFiles& files);

}  // namespace sslv
