// SPDX-License-Identifier: Apache-2.0
#include "capture/controls.h"

#include "capture/control_queue.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string_view name_of(ControlKind kind) {
  switch (kind) {
    case ControlKind::kFlag: return "flag";
    case ControlKind::kInteger: return "integer";
    case ControlKind::kNumber: return "number";
    case ControlKind::kChoice: return "choice";
    case ControlKind::kText: return "text";
    case ControlKind::kAction: break;
  }
  return "action";
}

std::string_view name_of(ControlLevel level) {
  switch (level) {
    case ControlLevel::kBeginner: return "beginner";
    case ControlLevel::kExpert: return "expert";
    case ControlLevel::kGuru: break;
  }
  return "guru";
}

std::string expected(const Control& control) {
  switch (control.kind) {
    case ControlKind::kFlag: return "true or false";
    case ControlKind::kText: return "a text";
    case ControlKind::kAction: return "anything";
    case ControlKind::kChoice: {
      std::string out;
      for (const std::string& choice : control.choices)
        out += (out.empty() ? "one of \"" : ", \"") + choice + '"';
      return out.empty() ? "nothing now" : out;
    }
    case ControlKind::kInteger:
    case ControlKind::kNumber: break;
  }
  std::string out = control.kind == ControlKind::kInteger ? "a whole number" : "a number";
  if (control.least) out += fmt::format(" from {:g}", *control.least);
  if (control.most) out += fmt::format(" to {:g}", *control.most);
  if (control.kind == ControlKind::kInteger && control.step && *control.step > 1)
    out += fmt::format(" in steps of {:g}", *control.step);
  return control.unit.empty() ? out : out + ' ' + control.unit;
}

bool takes(const Control& control, const Json& value) {
  switch (control.kind) {
    case ControlKind::kFlag: return value.is_boolean();
    case ControlKind::kText: return value.is_string();
    case ControlKind::kAction: return true;
    case ControlKind::kChoice:
      return value.is_string() && std::find(control.choices.begin(), control.choices.end(),
                                            value.get<std::string>()) != control.choices.end();
    case ControlKind::kInteger:
      if (!value.is_number_integer()) return false;
      break;
    case ControlKind::kNumber:
      if (!value.is_number()) return false;
      break;
  }
  const auto number = value.get<double>();
  if ((control.least && number < *control.least) || (control.most && number > *control.most)) return false;
  if (control.kind == ControlKind::kNumber || !control.step || *control.step <= 1) return true;
  return std::fmod(number - control.least.value_or(0), *control.step) == 0;
}

template <class T>
Json json_of(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace

Json control_json(const Control& control) {
  Json out{{"name", control.name},
           {"title", control.title},
           {"category", control.category},
           {"help", control.help},
           {"unit", control.unit},
           {"kind", name_of(control.kind)},
           {"level", name_of(control.level)},
           {"value", control.value},
           {"writable", control.writable}};
  if (control.kind == ControlKind::kInteger || control.kind == ControlKind::kNumber) {
    out["min"] = json_of(control.least);
    out["max"] = json_of(control.most);
    out["step"] = json_of(control.step);
  }
  if (control.kind == ControlKind::kChoice) out["choices"] = control.choices;
  return out;
}

void check_control_value(const Control& control, const Json& value) {
  if (takes(control, value)) return;
  throw SettingsError(fmt::format("{}: {} is not allowed; expected {}", control.name,
                                  shortened(json_text(value)), expected(control)));
}

bool is_same_value(const Control& control, const Json& a, const Json& b) {
  if (!a.is_number() || !b.is_number()) return a == b;
  const auto have = a.get<double>(), wanted = b.get<double>();
  return std::abs(have - wanted) <= std::max(control.step.value_or(0) * 0.99, std::abs(wanted) * 1e-4);
}

Controls::Controls() : queue_(std::make_unique<ControlQueue>(*this)) {}

Controls::~Controls() = default;

void Controls::set(const Control& control, const Json& value) {
  check_control_value(control, value);
  if (control.reopens) {
    throw NeedsReopening(
        fmt::format("{}: changing this reopens the camera. Save it to apply it.", control.name));
  }
  write(control, value);
}

}  // namespace sslv
