// SPDX-License-Identifier: Apache-2.0
#pragma once

// Alerts and checks on whether the field is ready to play, based on what the cameras detect.

#include "config/config.h"
#include "services/health_report.h"
#include "services/verdict/coverage.h"
#include "services/verdict/field_watch.h"

#include <array>
#include <optional>

namespace sslv {

struct VerdictFacts {
  const Config& config;
  FieldWatch::Seen seen;
  Coverage coverage;
  std::array<std::optional<int>, 2> robots_allowed;  // by Team, from the game controller; none: unknown
  // Before a match the check is strict: all robots of a roster must be seen. During a match robots leave and
  // come back, so only changes are reported.
  bool match_runs = false;
  bool half_is_next = false;  // teams take their places: no more robots than allowed may be on the field
  bool robots_are_handled = false;  // HALT or timeout: people may take robots off the field
};

/// Adds the alerts and the checks `robots`, `agreement` and `coverage`.
void report_verdict(const VerdictFacts& facts, HealthReport& report);

}  // namespace sslv
