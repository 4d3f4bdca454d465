// SPDX-License-Identifier: Apache-2.0
#include "capture/control_queue.h"

#include "capture/source.h"

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Maximum number of repetitions, for a camera that changes values while others are set.
constexpr int kRounds = 3;

/// Whether the control may change other controls, like an automatic mode.
bool is_mode(const Control& control) {
  return control.kind == ControlKind::kChoice || control.kind == ControlKind::kFlag;
}

/// Whether the control has a value that can be restored.
bool can_be_remembered(const Control& control) {
  return control.kind != ControlKind::kAction && !control.moves && !control.depends &&
         !control.value.is_null();
}

}  // namespace

const Control* ControlQueue::Memory::find(const std::string& name) const {
  const auto found = std::ranges::find(list, name, &Control::name);
  return found == list.end() ? nullptr : &*found;
}

ControlValues ControlQueue::Memory::home(ControlValues saved) const {
  saved.insert(opened.begin(), opened.end());
  return saved;
}

/// The values to set for a change of settings.
ControlValues ControlQueue::Memory::changed(const ControlValues& before, const ControlValues& wanted) const {
  ControlValues out = home(wanted);
  std::erase_if(out, [&](const auto& one) {
    const auto had = before.find(one.first), has = wanted.find(one.first);
    if (had == before.end() || has == wanted.end()) return had == before.end() && has == wanted.end();
    return had->second == has->second;
  });
  return out;
}

/// Keeps the driver alive during the call.
template <class Act>
auto ControlQueue::in_turn(Act act) {
  return [act = std::move(act), self = driver_.shared_from_this()] { return act(); };
}

ControlQueue::Refusals ControlQueue::open_with(const Json& wanted) {
  Refusals out;
  for (auto& [name, why] : set_all(wanted.get<ControlValues>(), true)) out.push_back(why);
  return out;
}

void ControlQueue::share_with(const Json& wanted) {
  calls_.post(in_turn([=, this] {
    RefusedByName refused = set_all(wanted.get<ControlValues>(), true);
    const std::lock_guard lock(mutex_);
    memory_.refused.merge(std::move(refused));
  }));
}

void ControlQueue::begin(std::shared_ptr<Controls> before) {
  calls_.post(in_turn([this, before = std::move(before)] {
    const bool is_first = memory().list.empty();  // tiles share a camera
    read_all();
    if (is_first && before) inherit(before->queue().memory());
  }));
}

std::vector<Control> ControlQueue::list() {
  return calls_.run(in_turn([this] { return read_all(); }));
}

Control ControlQueue::set(const std::string& name, const Json& value) {
  return calls_.run(in_turn([=, this] { return set_unsaved(name, value); }));
}

std::vector<Control> ControlQueue::revert(const std::set<std::string>& names, const Json& saved) {
  return calls_.run(in_turn([=, this] {
    revert_unsaved(names, saved.get<ControlValues>());
    return memory().list;
  }));
}

std::function<ControlQueue::Refusals()> ControlQueue::apply(const Json& before, const Json& wanted) {
  const auto refusals = std::make_shared<Refusals>();
  try {
    const auto call = calls_.post(in_turn(
        [=, this] { *refusals = carry_out(before.get<ControlValues>(), wanted.get<ControlValues>()); }));
    return [calls = calls_, call, refusals] {
      calls.wait(call);
      return *refusals;
    };
  } catch (const std::exception& error) {
    return [why = std::string(error.what())]() -> Refusals { throw CaptureError(why); };
  }
}

/// Sets plain values first, then modes, and repeats until nothing changes, because setting a value may end a
/// mode, and setting a mode may lock or change values. A control that stays locked is tried once if
/// `also_locked`, otherwise not at all.
ControlQueue::RefusedByName ControlQueue::set_all(const ControlValues& wanted, bool also_locked) {
  RefusedByName refused;
  bool has_set = true;
  for (int round = 0; round < kRounds && std::exchange(has_set, false); ++round) {
    const bool all = also_locked && round == 0;
    const auto is_due = [&](const Control& control, const Json& value) {
      if (!can_be_remembered(control)) return all || refused.contains(control.name);
      if (!is_same_value(control, control.value, value)) return all || control.writable;
      refused.erase(control.name);
      return false;
    };
    for (const bool modes : {false, true}) {
      for (const auto& [name, value] : wanted) {
        try {
          const Control control = read(name);
          if (is_mode(control) != modes || !is_due(control, value)) continue;
          write(control, value);
          refused.erase(name);
          has_set = true;
        } catch (const NeedsReopening&) {
          refused[name] = name + ": takes effect when the camera is opened again";
        } catch (const SettingsError& error) {
          refused[name] = error.what();
        } catch (const CaptureError& error) {  // the other controls may still answer
          refused[name] = name + ": " + error.what();
        }
      }
    }
  }
  return refused;
}

/// Sets controls to their home values. If a mode is restored to its earlier value, also restores the controls
/// that the mode changed, except unsaved controls.
ControlQueue::RefusedByName ControlQueue::take_home(const ControlValues& targets, const ControlValues& saved,
                                                    bool also_locked) {
  const Memory before = memory();
  RefusedByName refused = set_all(targets, also_locked);
  const bool takes_others = std::ranges::any_of(targets, [&](const auto& one) {
    const Control* had = before.find(one.first);
    if (had == nullptr || !is_mode(*had) || had->value == one.second) return false;
    const auto opened = before.opened.find(one.first);
    return before.unsaved.contains(one.first) ||
           (opened != before.opened.end() && opened->second == one.second);
  });
  read_all();
  if (!takes_others) return refused;
  ControlValues home = before.home(saved);
  const Memory now = memory();
  std::erase_if(home, [&](const auto& one) {
    const auto& [name, value] = one;
    const Control* control = now.find(name);
    return control == nullptr || !can_be_remembered(*control) || !control->writable || control->reopens ||
           is_same_value(*control, control->value, value) || refused.contains(name) ||
           (before.unsaved.contains(name) && !targets.contains(name));
  });
  if (home.empty()) return refused;
  refused.merge(set_all(home, false));
  read_all();
  return refused;
}

Control ControlQueue::set_unsaved(const std::string& name, const Json& value) {
  Control control = read(name);
  Memory before = memory();
  if (before.list.empty() || (before.unsaved.empty() && can_be_remembered(control))) {
    read_all();
    before = memory();
  }
  write(control, value);
  if (can_be_remembered(control)) {
    // Recorded before reading back, which may fail.
    const std::lock_guard lock(mutex_);
    control.value = value;
    memory_.unsaved.insert(name);
    std::ranges::replace(memory_.list, name, control, &Control::name);
  }
  control = driver_.get(name);
  const bool is_known_step = before.unsaved.contains(name) || !can_be_remembered(control);
  const bool is_step = is_known_step && !is_mode(control);  // a moving slider: read only this control
  const std::vector<Control> all = is_step ? std::vector<Control>{control} : read_all();
  const std::lock_guard lock(mutex_);
  memory_.ranges_are_old = memory_.ranges_are_old || is_step;
  for (const Control& now : all) {
    std::ranges::replace(memory_.list, now.name, now, &Control::name);
    const Control* had = before.find(now.name);
    const bool has_home = memory_.opened.contains(now.name);
    if (is_mode(now) && has_home && had != nullptr && had->value != now.value)
      memory_.unsaved.insert(now.name);
  }
  return control;
}

void ControlQueue::revert_unsaved(const std::set<std::string>& names, const ControlValues& saved) {
  const Memory before = memory();
  ControlValues targets = before.home(saved);
  std::erase_if(targets, [&](const auto& one) {
    return !before.unsaved.contains(one.first) || (!names.empty() && !names.contains(one.first));
  });
  // An automatic mode may have locked the control, which is an error only if the control was named.
  const RefusedByName refused = take_home(targets, saved, !names.empty());
  const std::lock_guard lock(mutex_);
  for (const auto& [name, value] : targets) {
    if (!refused.contains(name)) memory_.unsaved.erase(name);
  }
  for (const auto& [name, why] : refused) {
    if (targets.contains(name)) throw SettingsError(why);
  }
}

ControlQueue::Refusals ControlQueue::carry_out(const ControlValues& before, const ControlValues& wanted) {
  if (memory().list.empty()) read_all();
  const ControlValues targets = memory().changed(before, wanted);
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, value] : targets) memory_.unsaved.erase(name);
    // Also clears refusals of settings that no longer exist.
    std::erase_if(memory_.refused, [&](const auto& one) {
      return targets.contains(one.first) || !wanted.contains(one.first);
    });
  }
  Refusals out;
  const auto refuse = [&](RefusedByName refused) {
    for (const auto& [name, why] : refused) out.push_back(why);
    const std::lock_guard lock(mutex_);
    memory_.refused.merge(std::move(refused));
  };
  try {
    refuse(take_home(targets, wanted, true));
  } catch (const CaptureError& error) {
    RefusedByName all;
    for (const auto& [name, value] : targets) all[name] = name + ": " + error.what();
    refuse(std::move(all));
  }
  return out;
}

/// All controls are set through this function.
void ControlQueue::write(const Control& control, const Json& value) {
  driver_.set(control, value);
  const std::lock_guard lock(mutex_);
  memory_.refused.erase(control.name);
}

/// Reads a control before it is set. The first value read counts as the value at the camera's opening.
Control ControlQueue::read(const std::string& name) {
  Control now = driver_.get(name);
  const std::lock_guard lock(mutex_);
  if (can_be_remembered(now)) memory_.opened.emplace(name, now.value);
  return now;
}

std::vector<Control> ControlQueue::read_all() {
  std::vector<Control> now = driver_.list();
  const std::lock_guard lock(mutex_);
  for (const Control& control : now) {
    if (memory_.list.empty() && control.writable && can_be_remembered(control))
      memory_.opened.emplace(control.name, control.value);
  }
  memory_.list = now;
  memory_.ranges_are_old = false;
  return now;
}

/// Takes over the home values of the previous opening for controls whose value has not changed since then. A
/// control that is locked now inherits its home value in any case.
void ControlQueue::inherit(const Memory& before) {
  const std::lock_guard lock(mutex_);
  for (const auto& [name, home] : before.opened) {
    const Control* left = before.find(name);
    if (left == nullptr || memory_.find(name) == nullptr) continue;  // another camera may lack the control
    const auto [had, is_locked] = memory_.opened.emplace(name, home);
    if (!is_locked && !is_same_value(*left, had->second, left->value)) continue;
    had->second = home;
    if (before.unsaved.contains(name)) memory_.unsaved.insert(name);
  }
}

ControlPlan ControlQueue::plan(const Json& before, const Json& wanted, const std::string& path) const {
  const Memory known = memory();
  const ControlValues targets = known.changed(before.get<ControlValues>(), wanted.get<ControlValues>());
  ControlPlan out;
  for (const auto& [name, value] : targets) {
    const Control* control = known.find(name);
    out.reopens = out.reopens || (control != nullptr && control->reopens);
    if (!wanted.contains(name)) out.unsaid[name] = value;
    if (known.list.empty() || !wanted.contains(name)) continue;
    if (control == nullptr)
      throw SettingsError(fmt::format("{}/{}: the camera has no such control", path, name));
    if (control->kind == ControlKind::kChoice && control->choices.empty()) continue;  // unknown choices
    Control allowed = *control;
    if (targets.size() > 1 || control->moves || known.ranges_are_old)
      allowed.least = allowed.most = allowed.step = std::nullopt;
    try {
      check_control_value(allowed, value);
    } catch (const SettingsError& error) {
      throw SettingsError(fmt::format("{}/{}", path, error.what()));
    }
  }
  return out;
}

std::vector<UnsavedControl> ControlQueue::unsaved(const Json& saved) const {
  const std::lock_guard lock(mutex_);
  std::vector<UnsavedControl> out;
  for (const std::string& name : memory_.unsaved) {
    const Control* control = memory_.find(name);
    const auto kept = saved.find(name);
    const Json& home = kept != saved.end() ? *kept : memory_.opened.at(name);
    // A value that an automatic mode controls is no longer the admin's value.
    if (control != nullptr && control->writable && !is_same_value(*control, control->value, home))
      out.push_back({*control, home});
  }
  return out;
}

ControlQueue::Refusals ControlQueue::refused() const {
  const std::lock_guard lock(mutex_);
  Refusals out;
  for (const auto& [name, why] : memory_.refused) out.push_back(why);
  return out;
}

ControlQueue::Memory ControlQueue::memory() const {
  const std::lock_guard lock(mutex_);
  return memory_;
}

}  // namespace sslv
