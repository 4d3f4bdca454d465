// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether this field can play, by what is seen on it.

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
  std::array<std::optional<int>, 2> robots_allowed;  // by Team: by the game controller; none: it does not say
  // Before a match the check is strict: all robots that may play are to be there. While one runs, robots
  // leave and come back, and only what changes is news.
  bool match_runs = false;
  bool robots_are_handled = false;  // meanwhile: people may take them off, in a HALT or a timeout
};

/// Adds the alerts and the checks `robots`, `agreement` and `coverage`.
void report_verdict(const VerdictFacts& facts, HealthReport& report);

}  // namespace sslv
