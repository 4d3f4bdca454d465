// SPDX-License-Identifier: Apache-2.0
#pragma once

// What services say of how well things are: alerts, each with what to do, and the checks before a match.

#include "base/json.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

enum class Severity { kBad, kWarn, kInfo };
/// "bad", "warn", "info".
const char* name_of(Severity severity);

struct Alert {
  std::string id;     // its kind: "camera_lost"
  std::string check;  // id of the check that it belongs to
  Severity severity;
  std::string title, fix;
  std::string page{};           // of the panel, where it can be fixed; empty: not there
  std::optional<int> camera{};  // that it is about
  std::string about{};          // what else tells it from others of its kind: an address, say
  double since_s = 0;           // Unix time; see AlertTimes
};

enum class CheckState { kPass, kWarn, kFail };

/// One thing to be right before a match.
struct Check {
  std::string id, title;
  CheckState state = CheckState::kPass;
  std::string value, unit;  // the figure that says most; the unit may be empty
  std::string text;         // what was found besides; or what is wrong
};

/// Where there is no figure.
inline constexpr const char* kNoFigure = "\u2013";

/// One after the other, the services add to it; the status service then finishes it. Checks are shown in the
/// order in which they were added.
struct HealthReport {
  std::vector<Alert> alerts;
  std::vector<Check> checks;
  Json* status = nullptr;           // takes keys of docs/openapi.json's Status; null: nobody asks for them
  bool another_host_sends = false;  // a named computer sends detections too, with times of its own clock

  /// Alerts of one kind, as many of which strangers can cause: the first stands for all of them.
  void add_as_one(std::vector<Alert> same_kind);

  /// Sorts alerts, the worst first. Each check becomes as bad as its alerts, and the worst stands in the
  /// place of its text, unless it only informs.
  void finish();

  /// A match may begin: no check fails.
  bool is_go() const;
};

/// The title of an alert; `what`: packets, tracks. `some_leave`: to the group or to the broadcast address
/// they do.
std::string title_not_sent(std::string what, bool some_leave);

/// As docs/openapi.json has them.
Json to_json(const Alert& alert);
Json to_json(const Check& check);

}  // namespace sslv
