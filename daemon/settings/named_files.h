// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <filesystem>
#include <string>
#include <vector>

namespace sslv {

struct NamedFile {
  std::string path;  // JSON Pointer of the setting
  std::filesystem::path file;
};

/// All settings that name a file or folder, by the schema: strings with the format "file" (see file() of
/// base/params.h). Empty ones name none.
std::vector<NamedFile> named_files(const Json& schema, const Json& settings);

/// Whether a file lies in a folder, or is it. Links are followed, and .. is resolved.
bool lies_in(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Refuses files that `next` names and none of `known` trees does, unless they lie in one of `folders`: who
/// can change settings over the network is not to read, or learn of, any other file of this computer. Throws
/// SettingsError.
void check_named_files(const Json& schema, const Json& next, const std::vector<Json>& known,
                       const std::vector<std::filesystem::path>& folders);

}  // namespace sslv
