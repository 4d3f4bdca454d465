// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether this field can play, by what is seen on it.

#include "config/config.h"
#include "services/health_report.h"
#include "services/verdict/coverage.h"
#include "services/verdict/field_watch.h"

#include <vector>

namespace sslv {

struct VerdictFacts {
  const Config& config;
  FieldWatch::Seen seen;
  Coverage coverage;
};

/// Adds the alerts and the checks `robots`, `agreement` and `coverage`.
void report_verdict(const VerdictFacts& facts, HealthReport& report);

}  // namespace sslv
