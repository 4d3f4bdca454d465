// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "ctl/client.h"

#include <string>

namespace sslv {

/// Controls of docs/openapi.json as a table for a terminal.
std::string controls_text(const Json& controls);

/// Sets "NAME=VALUE" on a camera, or runs the action "NAME", and returns the control. `save`: also saves the
/// value in the settings. Throws ClientError with the daemon's message if it is refused.
Json set_control(const Client& daemon, int camera_id, const std::string& assignment, bool save);

}  // namespace sslv
