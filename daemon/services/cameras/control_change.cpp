// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/control_change.h"

#include "base/error.h"
#include "base/log.h"
#include "capture/control_memory.h"
#include "capture/source.h"

#include <algorithm>
#include <exception>
#include <set>

namespace sslv {

ControlChange::ControlChange(std::shared_ptr<Controls> controls, DriverCalls calls, const Json& before,
                             const Json& wanted, const std::string& path)
    : calls_(std::move(calls)), set_(std::make_shared<Set>()) {
  for (const auto& [name, value] : wanted.items()) {
    const bool is_new = !before.contains(name) || before.at(name) != value;
    (is_new ? set_->changed : set_->unchanged)[name] = value;
  }
  for (const auto& [name, value] : before.items()) {
    if (wanted.contains(name)) continue;
    if (const auto old = controls->memory().when_opened(name)) set_->restored[name] = *old;
  }
  set_->controls = std::move(controls);
  if (set_->changed.empty() && set_->restored.empty()) return;
  try {
    // It sets back by itself what it has set before one is refused, also when nobody waits for it any more.
    calls_.run([set = set_, path]() -> Json {
      try {
        set->set_all();
      } catch (const std::exception& error) {
        set->set_back();
        throw SettingsError(path + '/' + error.what());
      }
      if (set->phase.exchange(Set::Phase::kDone) == Set::Phase::kAbandoned) set->set_back();
      return {};
    });
  } catch (const CaptureError& error) {
    if (set_->phase.exchange(Set::Phase::kAbandoned) == Set::Phase::kDone) set_->set_back();
    throw SettingsError(path + ": not set: " + error.what());
  }
}

ControlChange::~ControlChange() {
  if (!set_ || set_->old_values.empty()) return;
  try {
    calls_.run([set = std::move(set_)]() -> Json {
      set->set_back();
      return {};
    });
  } catch (const std::exception& error) {
    log::warning("controls not set back: {}", error.what());
  }
}

void ControlChange::keep() noexcept {
  if (!set_) return;
  set_->old_values.clear();
  if (!set_->controls) return;
  for (const Json* values : {&set_->changed, &set_->restored}) set_->controls->memory().forget(*values);
}

void ControlChange::Set::set_all() {
  controls->memory().read_once();
  struct Wanted {
    std::string name;
    Json value;
    bool is_mode, must_be_set;
  };
  std::vector<Wanted> left;
  for (const bool is_change : {true, false}) {
    for (const auto& [name, value] : (is_change ? changed : restored).items())
      left.push_back({name, value, is_mode(controls->get(name)), is_change});
  }
  // A value may end an automatic, and an automatic may lock a value: values first, then modes, then the
  // values that were locked, then the modes that these have ended.
  std::stable_partition(left.begin(), left.end(), [](const Wanted& one) { return !one.is_mode; });
  std::vector<Wanted> modes;
  std::exception_ptr refusal;
  bool may_have_ended_modes = false;
  for (std::size_t before = left.size() + 1; !left.empty() && left.size() < before;) {
    before = left.size();
    refusal = nullptr;
    std::erase_if(left, [&](const Wanted& one) {
      try {
        set(controls->get(one.name), one.value, one.must_be_set);
        if (one.is_mode) modes.push_back(one);
        may_have_ended_modes = may_have_ended_modes || (!one.is_mode && !modes.empty());
        return true;
      } catch (const SettingsError&) {
        if (one.must_be_set && !refusal) refusal = std::current_exception();
        return false;
      }
    });
  }
  if (refusal) std::rethrow_exception(refusal);
  for (const Wanted& one : left) log::warning("{}: not set back", one.name);
  if (has_gone_back && restore_others()) may_have_ended_modes = true;
  if (!may_have_ended_modes || needs_opening) return;
  for (const Wanted& mode : modes) {
    if (controls->get(mode.name).value != mode.value) controls->set(mode.name, mode.value);
  }
}

void ControlChange::Set::set(const Control& control, const Json& value, bool is_wanted) {
  const ControlEffect effect = controls->set(control.name, value);
  if (control.kind == ControlKind::kAction) return;
  if (effect == ControlEffect::kWhenOpened) {
    needs_opening = true;
    if (!is_wanted) at_opening[control.name] = value;
  }
  old_values.emplace_back(control.name, control.value);
  if (is_mode(control) && control.value != value && controls->memory().when_opened(control.name) == value)
    has_gone_back = true;
}

bool ControlChange::Set::restore_others() {
  bool has_set = false;
  std::set<std::string> except;
  for (const Json* values : {&changed, &restored, &unchanged}) {
    for (const auto& [name, value] : values->items()) except.insert(name);
  }
  Json targets = controls->memory().others_when_opened(except);
  targets.update(unchanged);
  for (const UnsavedControl& one : controls->memory().unsaved(unchanged)) targets.erase(one.control.name);
  for (const Control& control : controls->list()) {
    const auto target = targets.find(control.name);
    if (target == targets.end() || is_mode(control) || !control.writable || control.moves ||
        is_same_value(control, control.value, *target))
      continue;
    try {
      set(control, *target, true);
      has_set = true;
    } catch (const SettingsError& error) {
      log::warning("not set back: {}", error.what());
    }
  }
  return has_set;
}

void ControlChange::Set::set_back() noexcept {
  for (; !old_values.empty(); old_values.pop_back()) {
    const auto& [name, value] = old_values.back();
    try {
      if (!value.is_null()) controls->set(name, value);
    } catch (const std::exception& error) {
      log::warning("not set back: {}", error.what());
    }
  }
}

}  // namespace sslv
