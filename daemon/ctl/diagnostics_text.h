// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <optional>
#include <string>

namespace sslv {

/// Returns the quantile of a Histogram of docs/openapi.json, in microseconds; none if it is empty.
std::optional<double> quantile_us(const Json& histogram, double share);

/// GET /api/diagnostics for a terminal: the computer, its clock, and durations.
std::string diagnostics_text(const Json& diagnostics);

}  // namespace sslv
