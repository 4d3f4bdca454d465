// SPDX-License-Identifier: Apache-2.0
#include "capture/controls.h"

#include "base/error.h"
#include "capture/control_memory.h"
#include "capture/source.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

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
                                  shortened(value.dump(-1, ' ', false, Json::error_handler_t::replace)),
                                  expected(control)));
}

bool is_same_value(const Control& control, const Json& a, const Json& b) {
  if (!a.is_number() || !b.is_number()) return a == b;
  const auto have = a.get<double>(), wanted = b.get<double>();
  return std::abs(have - wanted) <= std::max(control.step.value_or(0) * 0.99, std::abs(wanted) * 1e-4);
}

Controls::Controls() : memory_(std::make_unique<ControlMemory>(*this)) {}

Controls::~Controls() = default;

ControlEffect Controls::set(const std::string& name, const Json& value) {
  const Control control = get(name);
  check_control_value(control, value);
  memory_->note_first(control);
  return write(control, value);
}

std::vector<std::string> apply_controls(Controls& controls, const Json& wanted) {
  std::vector<std::pair<std::string, Json>> left;
  for (const auto& [name, value] : wanted.items()) left.emplace_back(name, value);
  std::vector<std::string> problems;
  for (std::size_t before = left.size() + 1; !left.empty() && left.size() < before;) {
    before = left.size();
    problems.clear();
    std::erase_if(left, [&](const auto& one) {
      try {
        controls.set(one.first, one.second);
        return true;
      } catch (const std::exception& error) {
        problems.emplace_back(error.what());
        return false;
      }
    });
  }
  return problems;
}

}  // namespace sslv
