// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "ctl/client.h"

#include <string>

namespace sslv {

/// Human-readable text for ColorState of docs/openapi.json.
std::string colors_text(const Json& state);

/// The same for a list of ColorMargin: a line for each label, or the reason why there is none.
std::string margins_text(const Json& margins);

/// The same for a ColorImport that was only tried: the colour tables in the file.
std::string tables_text(const Json& import);

/// Starts learning and returns the report. Throws ClientError if learning ends without a report.
Json learn_running(const Client& daemon, int camera_id, int frames);
/// Human-readable text for the report of learn_running().
std::string learning_text(const Json& report);

}  // namespace sslv
