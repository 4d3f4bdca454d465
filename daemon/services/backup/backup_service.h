// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/backup/backup_file.h"
#include "services/backup/kept_files.h"
#include "services/backup_part.h"
#include "services/service.h"
#include "services/settings/settings_editor.h"
#include "settings/state_folder.h"

#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sslv {

/// Backs up everything that the service stores into one file, and restores it on this computer or another.
class BackupService final : public Service {
 public:
  /// `parts`: the data stored beside the settings, except profiles and passwords. All must outlive this.
  BackupService(StateFolder& folder, SettingsEditor& settings, Passwords& passwords, Profiles& profiles,
                std::vector<BackupPart*> parts);

  std::vector<Route> routes() override;

 private:
  class Restored;
  struct Read;

  Response get_backup(const Request& request);
  Response check(const Request& request);
  Response restore(const Request& request);

  /// `is_whole`: throws StorageError if a table named in the settings is missing.
  Backup make(bool with_passwords, bool is_whole) const;
  /// Validates everything that does not need the settings' transaction. Throws SettingsError.
  Read read(const Request& request);
  Json contents_json(const Read& read);

  StateFolder& folder_;
  SettingsEditor& settings_;
  Passwords& passwords_;
  PasswordsPart passwords_part_;
  ProfilesPart profiles_part_;
  std::vector<BackupPart*> parts_;  // all, including profiles and passwords
  std::mutex mutex_;                // serializes reading and restoring backups
};

}  // namespace sslv
