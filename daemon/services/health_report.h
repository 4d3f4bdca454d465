// SPDX-License-Identifier: Apache-2.0
#pragma once

// Health reports of the services: alerts, each with its fix, and the checks before a match.

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
  std::string id;     // its kind, for example "camera_lost"
  std::string check;  // id of the check that it belongs to
  Severity severity;
  std::string title, fix;
  std::string page{};           // page of the panel where it can be fixed; empty: none
  std::optional<int> camera{};  // the camera it is about
  std::string about{};          // distinguishes alerts of one kind: an address, for example
  double since_s = 0;           // Unix time; see AlertTimes
};

/// kUnknown: nothing was measured yet, or there is nothing to measure. Does not prevent a match.
enum class CheckState { kPass, kUnknown, kWarn, kFail };

/// A condition to be met before a match.
struct Check {
  std::string id, title;
  CheckState state = CheckState::kPass;
  std::string value, unit;  // the most important figure; the unit may be empty
  std::string text;         // further findings, or the problem
};

/// Shown if there is no figure.
inline constexpr const char* kNoFigure = "\u2013";

/// Alerts and checks of all services. Each service adds its own, one after the other; the status service then
/// calls finish(). Checks are shown in the order in which they were added.
struct HealthReport {
  std::vector<Alert> alerts;
  std::vector<Check> checks;
  Json* status = nullptr;           // receives keys of docs/openapi.json's Status; null: not requested
  bool another_host_sends = false;  // a computer named in settings sends detections timed by its own clock

  /// Adds alerts of one kind as a single alert, represented by the first. Use it for kinds that unknown
  /// senders on the network can cause in any number.
  void add_as_one(std::vector<Alert> same_kind);

  /// The alert so far that shows a moved camera by its own lines; null: none. Other alerts about such a
  /// camera would tell the same event twice.
  const Alert* line_alert(int camera) const;

  /// Sorts the alerts, the worst first. Each check's state becomes at least as bad as its worst alert, whose
  /// title replaces the check's text. Alerts of kInfo do not change checks.
  void finish();

  /// Whether a match may begin: no check fails.
  bool is_go() const;
};

/// Title of an alert. `what`: "packets" or "tracks". `some_leave`: sending still works to either the group or
/// the broadcast address.
std::string title_not_sent(std::string what, bool some_leave);

/// As in docs/openapi.json.
Json to_json(const Alert& alert);
Json to_json(const Check& check);

}  // namespace sslv
