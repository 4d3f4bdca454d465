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

/// Everything that the service keeps, in one file, and back from one: on this computer or another.
class BackupService final : public Service {
 public:
  /// `parts`: what is kept beside the settings, but for passwords. All must outlive this.
  BackupService(StateFolder& folder, SettingsEditor& settings, Passwords& passwords, Profiles& profiles,
                std::vector<BackupPart*> parts);

  std::vector<Route> routes() override;

 private:
  class Restored;
  struct Read;

  Response get_backup(const Request& request);
  Response check(const Request& request);
  Response restore(const Request& request);

  /// `is_whole`: throws StorageError where a table that the settings name is lost.
  Backup make(bool with_passwords, bool is_whole) const;
  /// All that can be checked without the settings' transaction. Throws SettingsError.
  Read read(const Request& request);
  Json contents_json(const Read& read);

  StateFolder& folder_;
  SettingsEditor& settings_;
  Passwords& passwords_;
  PasswordsPart passwords_part_;
  ProfilesPart profiles_part_;
  std::vector<BackupPart*> parts_;  // all of them
  std::mutex mutex_;                // one is read or restored at a time
};

}  // namespace sslv
