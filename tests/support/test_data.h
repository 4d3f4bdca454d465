// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/paths.h"

#include <cstdlib>
#include <filesystem>

namespace sslv {

/// Recorded data from other teams that is not part of this repository. Tests that need it are skipped with a
/// message if it is missing. SSLV_TEST_DATA sets its folder.
inline std::filesystem::path test_data_folder() {
  const char* set = std::getenv("SSLV_TEST_DATA");
  return set != nullptr ? std::filesystem::path(set) : std::filesystem::path(source_path("/../shared/data"));
}

}  // namespace sslv
