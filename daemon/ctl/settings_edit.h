// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "ctl/client.h"

#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// What stands at a JSON Pointer of a tree. Throws std::runtime_error when nothing does.
const Json& value_at(const Json& tree, const std::string& pointer);

/// What a word of the command line stands for: JSON, or else the word itself as a text.
Json json_or_text(const std::string& word);

/// The JSON Patch that sets places of a tree, whether something is there or not. Throws std::runtime_error
/// for what is no JSON Pointer.
Json patch_that_sets(const Json& tree, const std::vector<std::pair<std::string, std::string>>& pairs);

/// Applies a JSON Patch that was made for `read`, the answer of GET /api/settings; `dry_run` only has it
/// checked. Answers {"changes": SettingsChange[]}, and with "revision" unless it was a dry run.
/// Throws ClientError when it is refused, also when the settings were changed since.
Json edit_settings(const Client& daemon, const Json& read, const Json& patch, bool dry_run);
/// The same of an edit that is done: both are answers with the settings and their revision.
Json edit_between(const Json& before, const Json& after);
/// That answer for a terminal.
std::string edit_text(const Json& edit);

/// The part of the settings' JSON Schema at a pointer, as a table: key, type, range, unit, help. In the
/// pointer and in keys `*` stands for any entry of a list. Throws std::runtime_error for a key that is not.
std::string schema_text(const Json& schema, const std::string& pointer);

}  // namespace sslv
