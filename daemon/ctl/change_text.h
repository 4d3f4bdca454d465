// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

/// A SettingsChange of docs/openapi.json in one line: "/site: "A" -> "B"".
std::string change_text(const Json& change);

/// The same for several changes: a line for each change.
std::string changes_text(const Json& changes);

/// The settings' history (SettingsStep of docs/openapi.json, newest first) for a terminal: a line for each
/// change.
std::string history_text(const Json& history);

/// Profiles of docs/openapi.json for a terminal: a list of all profiles; a single profile, with the changes
/// that applying it would make.
std::string profiles_text(const Json& profiles);
std::string profile_text(const Json& profile);

}  // namespace sslv
