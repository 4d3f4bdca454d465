// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>
#include <filesystem>
#include <vector>

namespace sslv {

/// Lists the entries of a folder that a camera's "path" may name: folders, and files that the backend "files"
/// reads, by extension. Users may change settings but must not see this computer's other files: nothing
/// outside `allowed` is listed, not even through links, and no name that the settings would refuse. If
/// `folder` is empty, lists the allowed folders. Returns FileList of docs/openapi.json. Throws SettingsError.
Json list_files(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& allowed);

/// Limit for a folder; further entries are only counted.
inline constexpr std::size_t kMaxListedFiles = 500;

}  // namespace sslv
