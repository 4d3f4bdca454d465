// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kit/stamp.h"

#include <filesystem>
#include <stdexcept>
#include <string>

namespace sslv {

/// A stage library that cannot be used; one line that says why, without the file's name.
struct StageLibraryError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// The stamp of a library, read from its file: nothing of it runs. Throws StageLibraryError for what is no
/// shared object, one of another processor, or one without a stamp.
StageStamp read_stamp(const std::filesystem::path& file);

/// Throws StageLibraryError unless a library with this stamp goes with this program.
void check_stamp(const StageStamp& stamp);

}  // namespace sslv
