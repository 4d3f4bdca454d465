// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace sslv {

/// Of a backup's file, and of all that is in it.
inline constexpr std::size_t kMaxBackupBytes = 16 * 1024 * 1024, kMaxUnpackedBackupBytes = 64 * 1024 * 1024;

}  // namespace sslv
