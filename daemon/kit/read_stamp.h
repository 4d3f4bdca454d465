// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kit/stamp.h"

#include <filesystem>
#include <stdexcept>
#include <string>

namespace sslv {

/// A stage library that cannot be used. The text is one line with the reason, without the file's name.
struct StageLibraryError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// Reads a library's stamp from its file without running any of its code. Throws StageLibraryError for a file
/// that is not a shared object, is for another processor, or has no stamp.
StageStamp read_stamp(const std::filesystem::path& file);

/// Throws StageLibraryError unless a library with this stamp is compatible with this program.
void check_stamp(const StageStamp& stamp);

}  // namespace sslv
