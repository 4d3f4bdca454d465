// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

/// The settings' history (SettingsStep of docs/openapi.json, newest first) for a terminal: a line for each
/// change.
std::string history_text(const Json& history);

}  // namespace sslv
