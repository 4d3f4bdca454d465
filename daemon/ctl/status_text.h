// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

// Texts for a terminal from answers of docs/openapi.json.

/// A stage's name and its library.
std::string stage_text(const Json& stage);

/// From GET /api/status.
std::string status_text(const Json& status);
/// From GET /api/cameras: a line for each camera.
std::string cameras_text(const Json& cameras);

/// Sorts alerts by severity, the worst first.
Json worst_first(Json alerts);
std::string alerts_text(const Json& alerts);
/// From GET /api/checks.
std::string checks_text(const Json& checks);
/// From a line of GET /api/log.
std::string log_line_text(const Json& line);

/// From GET /api/events: a line for each entry.
std::string events_text(const Json& events);
/// Returns the entries of GET /api/events that are alerts with the severity "bad".
Json only_bad(const Json& entries);

/// Whether any alert has the severity "bad".
bool any_bad(const Json& alerts);

}  // namespace sslv
