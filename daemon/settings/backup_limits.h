// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace sslv {

/// Limits of a backup file and of its unpacked content: both are in memory at the same time.
inline constexpr std::size_t kMaxBackupBytes = 8 * 1024 * 1024, kMaxUnpackedBackupBytes = 16 * 1024 * 1024;
/// Limit for colour tables in a backup: tables beyond it are left out unless the settings use them.
inline constexpr std::size_t kMaxTableBytesInBackup = 12 * 1024 * 1024;

}  // namespace sslv
