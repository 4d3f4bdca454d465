// SPDX-License-Identifier: Apache-2.0
#include "capture/control_queue.h"

#include "capture/source.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// A camera that measures while it is set is not chased for ever.
constexpr int kRounds = 3;

/// What may change other controls, such as an automatic.
bool is_mode(const Control& control) {
  return control.kind == ControlKind::kChoice || control.kind == ControlKind::kFlag;
}

/// Whether it has a value that can be set again.
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

/// The driver lives as long as the call.
template <class Act>
auto ControlQueue::in_turn(Act act) {
  return [act = std::move(act), self = driver_.shared_from_this()] { return act(); };
}

ControlQueue::Refusals ControlQueue::open_with(const Json& wanted) {
  Refusals out;
  try {
    for (auto& [name, why] : set_all(wanted.get<ControlValues>(), Which::kAll)) out.push_back(why);
  } catch (const CaptureError& error) {
    out.emplace_back(error.what());
  }
  return out;
}

void ControlQueue::begin(std::shared_ptr<Controls> before) {
  calls_.post(in_turn([this, before = std::move(before)] {
    const Memory known = memory();
    read_all();
    const bool is_first = known.list.empty();  // tiles share a camera
    if (is_first && before) inherit(before->queue().memory(), known.opened);
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

std::function<ControlQueue::Refusals()> ControlQueue::apply(ControlPlan plan) {
  const auto refusals = std::make_shared<Refusals>();
  try {
    const auto call =
        calls_.post(in_turn([this, refusals, plan = std::move(plan)] { *refusals = carry_out(plan); }));
    return [calls = calls_, call, refusals] {
      calls.wait(call);
      return *refusals;
    };
  } catch (const std::exception& error) {
    return [why = std::string(error.what())]() -> Refusals { throw CaptureError(why); };
  }
}

/// Values first, then modes, until nothing changes any more: a value may end a mode, and a mode may lock a
/// value or change it. Of `kDiffering`, and in later rounds, only what is not there and not locked.
ControlQueue::RefusedByName ControlQueue::set_all(const ControlValues& wanted, Which which) {
  RefusedByName refused;
  const auto is_due = [&](const Control& control, const Json& value, int round) {
    if (which == Which::kAll && round == 0) return true;
    if (!can_be_remembered(control)) return refused.contains(control.name);
    const bool is_there = is_same_value(control, control.value, value);
    if (is_there) refused.erase(control.name);
    return control.writable && !is_there;
  };
  bool has_set = true;
  for (int round = 0; round < kRounds && std::exchange(has_set, false); ++round) {
    for (const bool modes : {false, true}) {
      for (const auto& [name, value] : wanted) {
        try {
          const Control control = driver_.get(name);
          if (is_mode(control) != modes || !is_due(control, value, round)) continue;
          write(control, value);
          refused.erase(name);
          has_set = true;
        } catch (const SettingsError& error) {
          refused[name] = error.what();
        }
      }
    }
  }
  return refused;
}

/// Sets controls to what is their home with these settings. What a mode has changed that goes back to what it
/// was goes home with it, but for what is unsaved.
ControlQueue::RefusedByName ControlQueue::take_home(const ControlValues& targets, const ControlValues& saved,
                                                    Which which) {
  const Memory before = memory();
  RefusedByName refused = set_all(targets, which);
  const bool takes_others = std::ranges::any_of(targets, [&](const auto& one) {
    const Control* had = before.find(one.first);
    if (had == nullptr || !is_mode(*had) || had->value == one.second) return false;
    const auto opened = before.opened.find(one.first);
    return which == Which::kDiffering || (opened != before.opened.end() && opened->second == one.second);
  });
  if (!takes_others) return refused;
  ControlValues home = before.home(saved);
  std::erase_if(home, [&](const auto& one) {
    const bool is_others = before.unsaved.contains(one.first) && !targets.contains(one.first);
    return is_others || refused.contains(one.first);
  });
  refused.merge(set_all(home, Which::kDiffering));
  return refused;
}

/// The one place where a camera's controls are set.
void ControlQueue::write(const Control& control, const Json& value) {
  if (can_be_remembered(control)) {
    const std::lock_guard lock(mutex_);
    memory_.opened.emplace(control.name, control.value);
  }
  driver_.set(control, value);
}

Control ControlQueue::set_unsaved(const std::string& name, const Json& value) {
  if (!is_known()) read_all();
  Control control = driver_.get(name);
  const Memory before = memory();
  write(control, value);
  if (can_be_remembered(control)) {
    // Before it is read, which may fail.
    const std::lock_guard lock(mutex_);
    control.value = value;
    memory_.unsaved.insert(name);
    memory_.refused.erase(name);
    std::ranges::replace(memory_.list, name, control, &Control::name);
  }
  control = driver_.get(name);
  const bool is_known_step = before.unsaved.contains(name) || !can_be_remembered(control);
  const bool is_step = is_known_step && !is_mode(control);  // a slider has many
  const std::vector<Control> all = is_step ? std::vector<Control>{control} : read_all();
  const std::lock_guard lock(mutex_);
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
  const RefusedByName refused = take_home(targets, saved, Which::kDiffering);
  read_all();
  std::string problem;
  const std::lock_guard lock(mutex_);
  for (const auto& [name, value] : targets) {
    const Control* now = memory_.find(name);
    // A camera that measures may have another value already, and so has what an automatic took over again.
    const bool is_locked =
        now != nullptr && !now->writable && !names.empty() && !is_same_value(*now, now->value, value);
    if (const auto refusal = refused.find(name); refusal != refused.end()) {
      problem = refusal->second;
    } else if (is_locked) {
      problem = fmt::format("{}: not set back: another control sets it, such as an automatic mode", name);
    } else {
      memory_.unsaved.erase(name);
    }
  }
  if (!problem.empty()) throw SettingsError(problem);
}

ControlQueue::Refusals ControlQueue::carry_out(const ControlPlan& plan) {
  if (!is_known()) read_all();
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, value] : plan.targets) {
      memory_.unsaved.erase(name);
      memory_.refused.erase(name);
    }
  }
  Refusals out;
  RefusedByName refused = take_home(plan.targets, plan.saved, Which::kAll);
  read_all();
  const std::lock_guard lock(mutex_);
  for (auto& [name, why] : refused) {
    // Not known when this was planned.
    const Control* now = memory_.find(name);
    if (now != nullptr && now->reopens) why = name + ": takes effect when the camera is opened again";
    out.push_back(why);
    memory_.refused[name] = why;
  }
  return out;
}

std::vector<Control> ControlQueue::read_all() {
  std::vector<Control> now = driver_.list();
  const std::lock_guard lock(mutex_);
  for (const Control& control : now) {
    if (memory_.list.empty() && control.writable && can_be_remembered(control))
      memory_.opened.emplace(control.name, control.value);
  }
  memory_.list = now;
  return now;
}

/// `ours`: what those had that were set at this opening. One that had its value already was set at an earlier
/// one.
void ControlQueue::inherit(const Memory& before, const ControlValues& ours) {
  const std::lock_guard lock(mutex_);
  const auto has_now = [this](const std::string& name, const Json& value) {
    const Control* now = memory_.find(name);  // another camera may have no such control
    return now != nullptr && (!now->writable || is_same_value(*now, now->value, value));
  };
  ControlValues opened = before.opened;
  std::erase_if(opened, [&](const auto& one) {
    const auto set = ours.find(one.first);
    return set != ours.end() && !has_now(one.first, set->second);
  });
  for (const std::string& name : before.unsaved) {
    const Control* left = before.find(name);
    if (left != nullptr && has_now(name, left->value)) memory_.unsaved.insert(name);
  }
  const bool has_kept =
      std::ranges::any_of(ours, [&](const auto& one) { return opened.contains(one.first); });
  if (!has_kept && memory_.unsaved.empty()) return;
  opened.merge(memory_.opened);
  memory_.opened = std::move(opened);
}

bool ControlQueue::is_known() const {
  const std::lock_guard lock(mutex_);
  return !memory_.list.empty();
}

ControlPlan ControlQueue::plan(const Json& before, const Json& wanted, const std::string& path) const {
  const Memory known = memory();
  ControlPlan out{{}, wanted.get<ControlValues>()};
  for (const auto& [name, value] : known.home(out.saved)) {
    const auto had = before.find(name), has = wanted.find(name);
    const bool is_same = had == before.end() ? has == wanted.end() : has != wanted.end() && *had == *has;
    if (!is_same) out.targets[name] = value;
  }
  for (const auto& [name, value] : out.targets) {
    const Control* control = known.find(name);
    out.reopens |= control != nullptr && control->reopens;
    if (known.list.empty() || !wanted.contains(name)) continue;
    if (control == nullptr)
      throw SettingsError(fmt::format("{}/{}: the camera has no such control", path, name));
    if (control->kind == ControlKind::kChoice && control->choices.empty()) continue;  // not known now
    Control allowed = *control;
    if (out.targets.size() > 1 || control->moves) allowed.least = allowed.most = allowed.step = std::nullopt;
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
    // What an automatic has taken over is not the admin's value any more.
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
