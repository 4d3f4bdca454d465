// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "ctl/client.h"

#include <string>

namespace sslv {

/// Controls of docs/openapi.json as a table for a terminal.
std::string controls_text(const Json& controls);

/// Sets "NAME=VALUE" at a camera, or does the action "NAME", and answers with the control. `save`: into the
/// settings too. Throws ClientError with the daemon's words when it is refused.
Json set_control(const Client& daemon, int camera_id, const std::string& assignment, bool save);

}  // namespace sslv
