// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/paths.h"

#include <cstdlib>
#include <filesystem>

namespace sslv {

/// Recorded data that others made and that this repository does not hold. A test that needs it skips, saying
/// so, where it is not there. SSLV_TEST_DATA names its folder.
inline std::filesystem::path test_data_folder() {
  const char* set = std::getenv("SSLV_TEST_DATA");
  return set != nullptr ? std::filesystem::path(set) : std::filesystem::path(source_path("/../shared/data"));
}

}  // namespace sslv
