// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/saved_with.h"

#include <map>
#include <memory>
#include <string>

namespace sslv {

struct Config;

/// Files of a backup, by their names, which are the same as in the state folder.
using BackupFiles = std::map<std::string, std::string>;

/// Data stored beside the settings, as a part of a backup. Thread-safe.
class BackupPart {
 public:
  virtual ~BackupPart() = default;

  /// Returns the current files, for these settings. Files that cannot be read are left out.
  virtual BackupFiles files(const Config& config) const = 0;
  /// Whether a file of this name belongs to this part.
  virtual bool has(const std::string& name) const = 0;

  /// Reads this part's files from a backup, which will replace the current files. While the result exists,
  /// settings may already use their contents; nothing else changes until the result is saved. Throws
  /// SettingsError with a message that begins with the file's name.
  virtual std::unique_ptr<SavedWith> prepare(BackupFiles files) = 0;
};

}  // namespace sslv
