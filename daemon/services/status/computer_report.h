// SPDX-License-Identifier: Apache-2.0
#pragma once

// Alerts, checks and JSON of this computer.

#include "base/json.h"
#include "health/computer.h"
#include "services/health_report.h"

#include <optional>

namespace sslv {

/// Adds alerts and the checks "clock" and "computer".
void report_computer(const ComputerFigures& computer, const std::optional<ClockFigures>& clock,
                     HealthReport& report);

/// "system" and "clock" of docs/openapi.json's Diagnostics.
Json computer_json(const ComputerFigures& computer);
Json clock_json(const std::optional<ClockFigures>& clock);

}  // namespace sslv
