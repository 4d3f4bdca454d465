// SPDX-License-Identifier: Apache-2.0
#pragma once

// A backup is a .tar.gz with a manifest, the files of its parts, and SHA256SUMS, which `sha256sum --check`
// reads, of all the others. The sums find damage. They do not tell who made a backup: what is in one is
// checked as what comes over the network is.

#include "base/json.h"
#include "services/backup_part.h"

#include <cstdint>
#include <stop_token>
#include <string>
#include <string_view>

namespace sslv {

/// Where a backup is from.
struct BackupManifest {
  double time_s = 0;
  std::string version;  // of the program
  std::string computer, site;
};

struct Backup {
  BackupManifest manifest;
  BackupFiles files;
};

/// Its bytes. Throws StorageError when they would be too many, or it is told to stop.
std::string write_backup(Backup backup, const std::stop_token& stop = {});

/// Throws SettingsError where they are none, or damaged, or one that a newer program made, or it is told to
/// stop.
Backup read_backup(std::string_view bytes, const std::stop_token& stop = {});

}  // namespace sslv
