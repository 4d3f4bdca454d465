// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <optional>
#include <string>

namespace sslv {

/// The duration in a Histogram of docs/openapi.json below which this share of it lies; none of an empty one.
std::optional<double> quantile_us(const Json& histogram, double share);

/// GET /api/diagnostics for a terminal: the computer, its clock, and what takes how long.
std::string diagnostics_text(const Json& diagnostics);

}  // namespace sslv
