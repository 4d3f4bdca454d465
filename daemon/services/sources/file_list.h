// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>
#include <filesystem>
#include <vector>

namespace sslv {

/// What a camera's "path" may name in a folder, for somebody who may change settings but may not see this
/// computer's other files: folders, and files that the backend "files" reads, by their endings. Nothing
/// outside `allowed` is listed, wherever a link leads, and nothing whose name the settings would refuse.
/// `folder` empty: the allowed folders themselves. docs/openapi.json's FileList. Throws SettingsError.
Json list_files(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& allowed);

/// Of a folder; the others are counted.
inline constexpr std::size_t kMaxListedFiles = 500;

}  // namespace sslv
