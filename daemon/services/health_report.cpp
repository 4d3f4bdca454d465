// SPDX-License-Identifier: Apache-2.0
#include "services/health_report.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace sslv {
const char* name_of(Severity severity) {
  switch (severity) {
    case Severity::kBad: return "bad";
    case Severity::kWarn: return "warn";
    case Severity::kInfo: break;
  }
  return "info";
}

namespace {

const char* name_of(CheckState state) {
  switch (state) {
    case CheckState::kPass: return "pass";
    case CheckState::kUnknown: return "unknown";
    case CheckState::kWarn: return "warn";
    case CheckState::kFail: break;
  }
  return "fail";
}

}  // namespace

void HealthReport::add_as_one(std::vector<Alert> same_kind) {
  if (same_kind.empty()) return;
  Alert& first = same_kind.front();
  first.about.clear();  // so that it stays the same alert when other senders cause it
  if (same_kind.size() > 1) first.title += fmt::format(" (and {} more)", same_kind.size() - 1);
  alerts.push_back(std::move(first));
}

const Alert* HealthReport::line_alert(int camera) const {
  const auto found = std::ranges::find_if(alerts, [&](const Alert& alert) {
    return alert.camera == camera && (alert.id == "lines_off" || alert.id == "lines_missing");
  });
  return found == alerts.end() ? nullptr : &*found;
}

void HealthReport::finish() {
  std::stable_sort(alerts.begin(), alerts.end(),
                   [](const Alert& a, const Alert& b) { return a.severity < b.severity; });
  for (Check& check : checks) {
    const auto counts = [&](const Alert& alert) {
      return alert.check == check.id && alert.severity != Severity::kInfo;
    };
    const auto worst = std::find_if(alerts.begin(), alerts.end(), counts);
    if (worst == alerts.end()) continue;
    const auto count = std::count_if(alerts.begin(), alerts.end(), counts);
    check.text = worst->title;
    if (count > 1) check.text += fmt::format(" (and {} more)", count - 1);
    check.state =
        std::max(check.state, worst->severity == Severity::kBad ? CheckState::kFail : CheckState::kWarn);
  }
}

bool HealthReport::is_go() const {
  return std::none_of(checks.begin(), checks.end(),
                      [](const Check& check) { return check.state == CheckState::kFail; });
}

std::string title_not_sent(std::string what, bool some_leave) {
  if (!some_leave) return fmt::format("No {} are sent", what);
  what[0] = static_cast<char>(std::toupper(what[0]));
  return what + " do not leave both ways";
}

Json to_json(const Alert& alert) {
  return {{"id", alert.id},
          {"severity", name_of(alert.severity)},
          {"title", alert.title},
          {"fix", alert.fix},
          {"camera", alert.camera ? Json(*alert.camera) : Json(nullptr)},
          {"page", alert.page.empty() ? Json(nullptr) : Json(alert.page)},
          {"since", alert.since_s}};
}

Json to_json(const Check& check) {
  return {{"id", check.id},       {"title", check.title}, {"state", name_of(check.state)},
          {"value", check.value}, {"unit", check.unit},   {"text", check.text}};
}

}  // namespace sslv
