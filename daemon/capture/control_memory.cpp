// SPDX-License-Identifier: Apache-2.0
#include "capture/control_memory.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// A camera that measures while it is set back is not chased for ever.
constexpr int kRounds = 3;

bool can_be_remembered(const Control& control) {
  return control.kind != ControlKind::kAction && !control.moves && !control.depends &&
         !control.value.is_null();
}

std::map<std::string, Json> values_of(const std::vector<Control>& controls) {
  std::map<std::string, Json> out;
  for (const Control& control : controls) {
    if (control.writable && can_be_remembered(control)) out[control.name] = control.value;
  }
  return out;
}

}  // namespace

UnsavedControl* ControlMemory::find(const std::string& name) {
  const auto found = std::ranges::find(entries_, name, [](const auto& entry) { return entry.control.name; });
  return found == entries_.end() ? nullptr : &*found;
}

void ControlMemory::note_first(const Control& before) {
  if (!can_be_remembered(before)) return;
  const std::lock_guard lock(mutex_);
  first_.emplace(before.name, before.value);
}

void ControlMemory::read_once() {
  {
    const std::lock_guard lock(mutex_);
    if (was_read_) return;
  }
  update(controls_.list());
}

Control ControlMemory::set_unsaved(const std::string& name, const Json& value) {
  const Control before = controls_.get(name);
  if (!can_be_remembered(before)) {
    controls_.set(name, value);
    return controls_.get(name);
  }
  bool is_first = false, is_clean = false;
  {
    const std::lock_guard lock(mutex_);
    is_first = find(name) == nullptr;
    is_clean = entries_.empty();
  }
  Values clean;
  if (is_clean) {
    const std::vector<Control> all = controls_.list();
    clean = values_of(all);
    update(all);
  }
  if (controls_.set(name, value) == ControlEffect::kWhenOpened)
    throw NeedsReopening(fmt::format("{}: changing this reopens the camera. Save it to apply it.", name));
  {
    // Before it is read, which may fail.
    const std::lock_guard lock(mutex_);
    if (is_clean) clean_ = clean;
    if (is_first) entries_.push_back({before, before.value});
    find(name)->control.value = value;
  }
  Control now = controls_.get(name);
  const std::vector<Control> all = is_first ? controls_.list() : std::vector<Control>{};
  update_one(now);
  const std::lock_guard lock(mutex_);
  for (const Control& other : all) {
    const auto was = clean_.find(other.name);
    if (is_mode(other) && was != clean_.end() && was->second != other.value && find(other.name) == nullptr)
      entries_.push_back({other, was->second});
  }
  return now;
}

ControlMemory::Values ControlMemory::set_all(const Values& targets) {
  Values refusals;
  bool is_done = false;
  for (int round = 0; round < kRounds && !std::exchange(is_done, true); ++round) {
    for (const bool modes : {false, true}) {
      for (const auto& [name, target] : targets) {
        try {
          const Control control = controls_.get(name);
          if (is_mode(control) != modes || !control.writable || is_same_value(control, control.value, target))
            continue;
          controls_.set(name, target);
          refusals.erase(name);
          is_done = false;
        } catch (const SettingsError& error) {
          refusals[name] = error.what();
        }
      }
    }
  }
  return refusals;
}

void ControlMemory::revert(const std::set<std::string>& names) {
  const auto is_chosen = [&](const UnsavedControl& entry) {
    return names.empty() || names.contains(entry.control.name);
  };
  std::vector<UnsavedControl> chosen;
  std::vector<std::string> others;  // unsaved too, which a mode that goes back may lock or let go
  Values targets;
  {
    const std::lock_guard lock(mutex_);
    std::ranges::copy_if(entries_, std::back_inserter(chosen), is_chosen);
    const bool has_mode =
        std::ranges::any_of(chosen, [](const auto& entry) { return is_mode(entry.control); });
    if (has_mode) targets = clean_;
    for (const auto& entry : entries_) {
      targets.erase(entry.control.name);
      if (!is_chosen(entry)) others.push_back(entry.control.name);
    }
  }
  for (auto entry = chosen.rbegin(); entry != chosen.rend(); ++entry) {
    targets[entry->control.name] = entry->before;
    try {
      controls_.set(entry->control.name, entry->before);
    } catch (const SettingsError&) {  // NOLINT(bugprone-empty-catch): a mode may lock it that goes back below
    }
  }
  const Values refusals = set_all(targets);
  for (const std::string& name : others) update_one(controls_.get(name));
  std::string problem;
  for (const UnsavedControl& entry : chosen) {
    const Control now = controls_.get(entry.control.name);
    update_one(now);
    const auto refusal = refusals.find(now.name);
    if (refusal != refusals.end()) {
      problem = refusal->second.get<std::string>();
    } else if (!now.writable && !names.empty() && !is_same_value(now, now.value, entry.before)) {
      problem = fmt::format("{}: not set back: another control sets it, such as an automatic mode", now.name);
    } else {
      // A camera that measures may have another value already, and so has what an automatic took over again.
      const std::lock_guard lock(mutex_);
      std::erase_if(entries_, [&](const auto& one) { return one.control.name == now.name; });
    }
  }
  if (!problem.empty()) throw SettingsError(problem);
}

void ControlMemory::inherit(const ControlMemory& before) {
  Values first, opened, clean, ours;
  std::vector<UnsavedControl> entries;
  bool was_read = false;
  {
    const std::lock_guard lock(before.mutex_);
    first = before.first_, opened = before.opened_, clean = before.clean_, entries = before.entries_;
    was_read = before.was_read_;
  }
  {
    const std::lock_guard lock(mutex_);
    ours = first_;
  }
  const auto has_now = [&](const std::string& name, const Json& value) {
    try {
      const Control now = controls_.get(name);
      return !now.writable || is_same_value(now, now.value, value);
    } catch (const SettingsError&) {
      return false;  // another camera has no such control
    }
  };
  // One that was set at this opening to what the camera had already was set at an earlier one.
  std::erase_if(first, [&](const auto& one) {
    const auto found = ours.find(one.first);
    return found == ours.end() || !has_now(found->first, found->second);
  });
  std::erase_if(entries, [&](const auto& one) { return !has_now(one.control.name, one.control.value); });
  const std::lock_guard lock(mutex_);
  const bool has_kept = !first.empty() || !entries.empty();
  for (const auto& [name, value] : first) first_[name] = value;
  entries_ = std::move(entries);
  clean_ = std::move(clean);
  if (!has_kept || !was_read || was_read_) return;
  opened_ = std::move(opened);
  was_read_ = true;
}

void ControlMemory::update_one(const Control& now) {
  const std::lock_guard lock(mutex_);
  if (UnsavedControl* entry = find(now.name)) entry->control = now;
}

void ControlMemory::update(const std::vector<Control>& now) {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(was_read_, true)) opened_ = values_of(now);
  for (const Control& control : now) {
    if (UnsavedControl* entry = find(control.name)) entry->control = control;
  }
}

void ControlMemory::forget(const Json& values) {
  const std::lock_guard lock(mutex_);
  for (const auto& [name, value] : values.items()) {
    std::erase_if(entries_, [&key = name](const auto& entry) { return entry.control.name == key; });
    if (clean_.contains(name)) clean_[name] = value;
  }
}

std::vector<UnsavedControl> ControlMemory::unsaved(const Json& saved) const {
  const std::lock_guard lock(mutex_);
  std::vector<UnsavedControl> out;
  for (const UnsavedControl& entry : entries_) {
    const Control& control = entry.control;
    const auto kept = saved.find(control.name);
    const bool is_saved = kept != saved.end() && is_same_value(control, control.value, *kept);
    // What an automatic has taken over is not the admin's value any more.
    if (!is_saved && control.writable && !is_same_value(control, control.value, entry.before))
      out.push_back(entry);
  }
  return out;
}

std::optional<Json> ControlMemory::when_opened(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  for (const Values* values : {&first_, &opened_}) {
    if (const auto found = values->find(name); found != values->end()) return found->second;
  }
  return std::nullopt;
}

Json ControlMemory::others_when_opened(const std::set<std::string>& except) const {
  const std::lock_guard lock(mutex_);
  Json out = Json::object();
  for (const auto& [name, value] : opened_) {
    const bool is_unsaved =
        std::ranges::any_of(entries_, [&key = name](const auto& entry) { return entry.control.name == key; });
    if (!is_unsaved && !except.contains(name)) out[name] = value;
  }
  return out;
}

}  // namespace sslv
