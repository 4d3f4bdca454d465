// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "ctl/client.h"

#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// Returns the value at a JSON Pointer of a tree. Throws std::runtime_error if there is none.
const Json& value_at(const Json& tree, const std::string& pointer);

/// Reads a word of the command line as JSON, or else as text.
Json json_or_text(const std::string& word);

/// Returns the JSON Patch that sets values of a tree, whether or not they exist. Throws std::runtime_error
/// for an invalid JSON Pointer.
Json patch_that_sets(const Json& tree, const std::vector<std::pair<std::string, std::string>>& pairs);

/// Applies a JSON Patch that was made for `read`, the answer of GET /api/settings; `dry_run` only validates
/// it. Returns {"changes": SettingsChange[]}, with "revision" unless it was a dry run. Throws ClientError if
/// it is refused, also if the settings were changed since.
Json edit_settings(const Client& daemon, const Json& read, const Json& patch, bool dry_run);
/// Returns the same for an edit that is already made. `before`, `after`: answers with "settings" and
/// "revision".
Json edit_between(const Json& before, const Json& after);
/// Text for a terminal from the result of edit_settings() or edit_between().
std::string edit_text(const Json& edit);

/// The part of the settings' JSON Schema at a pointer, as a table: key, type, range, unit, help. `*` in the
/// pointer and in keys stands for any entry of a list. Throws std::runtime_error for an unknown key.
std::string schema_text(const Json& schema, const std::string& pointer);

}  // namespace sslv
