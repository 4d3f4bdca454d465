// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "alerts.h"

#include <string>
#include <vector>

namespace sslv {

enum class CheckState { kPass, kWarn, kFail };

/// One thing to be right before a match.
struct Check {
  CheckId id;
  CheckState state;
  std::string value, unit;  // the figure that says most; the unit may be empty
  std::string text;         // what was found besides; or what is wrong
};

/// Each is as bad as its alerts. Latency, referee and clock also warn of what matters before a match alone
/// and so is no alert.
std::vector<Check> make_checks(const HealthInput& input, const std::vector<Alert>& alerts);

/// A match may begin: none fails.
bool is_go(const std::vector<Check>& checks);

/// As docs/openapi.json has it.
Json to_json(const Check& check);

}  // namespace sslv
