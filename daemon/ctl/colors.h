// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "ctl/client.h"

#include <string>

namespace sslv {

/// docs/openapi.json's ColorState for people.
std::string colors_text(const Json& state);

/// Its ColorMargin list: a line for each label, or why there is none.
std::string margins_text(const Json& margins);

/// Its ColorImport when nothing was imported: what the file holds.
std::string tables_text(const Json& import);

/// Starts learning and waits for the report. Throws ClientError when it comes to none.
Json learn_running(const Client& daemon, int camera_id, int frames);
/// That report for people.
std::string learning_text(const Json& report);

}  // namespace sslv
