// SPDX-License-Identifier: Apache-2.0
#pragma once

// A backup is a .tar.gz with a manifest, the files of its parts, and SHA256SUMS, which has the checksums of
// all other files for `sha256sum --check`. The checksums detect damage but do not prove who made a backup:
// its content is validated like input from the network.

#include "base/json.h"
#include "services/backup_part.h"

#include <cstdint>
#include <stop_token>
#include <string>
#include <string_view>

namespace sslv {

/// Origin of a backup.
struct BackupManifest {
  double time_s = 0;
  std::string version;  // version of the program that made it
  std::string computer, site;
};

struct Backup {
  BackupManifest manifest;
  BackupFiles files;
};

/// Returns the backup's bytes. Throws StorageError if the backup is too large, or when stopped.
std::string write_backup(Backup backup, const std::stop_token& stop = {});

/// Throws SettingsError if the bytes are not a backup, are damaged or were made by a newer program, or when
/// stopped.
Backup read_backup(std::string_view bytes, const std::stop_token& stop = {});

}  // namespace sslv
