// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/saved_with.h"

#include <map>
#include <memory>
#include <string>

namespace sslv {

struct Config;

/// Files of a backup, by their names in it: those that they have in the state folder.
using BackupFiles = std::map<std::string, std::string>;

/// What is kept beside the settings, as a part of a backup. May be used from any thread.
class BackupPart {
 public:
  virtual ~BackupPart() = default;

  /// As they are now, with these settings. What cannot be read is left out.
  virtual BackupFiles files(const Config& config) const = 0;
  /// Whether a file with this name is of this part.
  virtual bool has(const std::string& name) const = 0;

  /// Reads `files`, those of a backup that it has, which are to take the place of those there are. Until what
  /// is returned goes, settings may use what the files hold; nothing else changes before it is saved. Throws
  /// SettingsError, beginning with the file's name.
  virtual std::unique_ptr<SavedWith> prepare(BackupFiles files) = 0;
};

}  // namespace sslv
