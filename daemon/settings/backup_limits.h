// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace sslv {

/// Of a backup's file, and of all that is in it: both are in memory at once.
inline constexpr std::size_t kMaxBackupBytes = 8 * 1024 * 1024, kMaxUnpackedBackupBytes = 16 * 1024 * 1024;
/// Of the colour tables that are written into one: the settings' own and the newest.
inline constexpr std::size_t kMaxTableBytesInBackup = 12 * 1024 * 1024;

}  // namespace sslv
