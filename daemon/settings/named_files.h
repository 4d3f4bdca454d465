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

/// Returns all settings that name a file or folder: strings with the format "file" in the schema (see file()
/// of base/params.h). Empty strings are left out.
std::vector<NamedFile> named_files(const Json& schema, const Json& settings);

/// Whether a file lies in a folder or is that folder. Follows links and resolves "..".
bool lies_in(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Throws SettingsError for a file that `next` names but no tree in `known` names, unless the file lies in
/// one of `folders`. Otherwise a person who can change settings over the network could read, or detect, any
/// other file of this computer.
void check_named_files(const Json& schema, const Json& next, const std::vector<Json>& known,
                       const std::vector<std::filesystem::path>& folders);

}  // namespace sslv
