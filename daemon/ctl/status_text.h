// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

// Answers of docs/openapi.json for a terminal.

/// A stage's name, and the library that it comes from.
std::string stage_text(const Json& stage);

/// Of GET /api/status.
std::string status_text(const Json& status);
/// Of GET /api/cameras: a line for each.
std::string cameras_text(const Json& cameras);

/// Alerts by how bad they are, the worst first.
Json worst_first(Json alerts);
std::string alerts_text(const Json& alerts);
/// Of GET /api/checks.
std::string checks_text(const Json& checks);
/// A line of GET /api/log.
std::string log_line_text(const Json& line);

/// Of GET /api/events: a line for each entry.
std::string events_text(const Json& events);
/// Alerts that are or were bad.
Json only_bad(const Json& entries);

/// An alert says that something is bad.
bool any_bad(const Json& alerts);

}  // namespace sslv
