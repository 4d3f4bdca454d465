// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sslv {

/// One step of the settings, as it is saved and shown:
/// {"revision": 7, "time": 1790000000.1, "who": "192.168.1.5", "what": "", "changes": [{"op": "replace",
/// "path": "/site", "before": "A", "after": "B"}]}. "op" is "add", "remove" or "replace"; "time" is Unix time
/// in seconds, "what" says what the step was part of.
using SettingsStep = Json;

/// What makes one tree out of another, one value after the other.
Json changes_between(const Json& before, const Json& after);

/// Those at or below one of these JSON Pointers.
Json changes_below(const Json& changes, const std::vector<std::string>& paths);

/// The JSON Patches that make such changes, and that take them back.
Json forward_patch(const Json& changes);
Json backward_patch(const Json& changes);

/// A JSON Patch that makes exactly one tree out of another: also where free objects have their keys in
/// another order, or a number is written as 1.0 for 1, which is the same to Json::diff().
Json exact_patch(const Json& before, const Json& after);

/// Throws SettingsError unless these are steps as SettingsHistory::newer_than() gives them, the first of them
/// no newer than `revision`.
void check_steps(const Json& steps, std::uint64_t revision);

/// The newest steps, as many as fit a quota.
class SettingsHistory {
 public:
  static constexpr std::size_t kMaxSteps = 300, kMaxBytes = 512 * 1024;

  SettingsHistory() = default;
  /// From what to_json() returned; anything but a list of steps is ignored.
  explicit SettingsHistory(const Json& saved);

  void add(SettingsStep step);
  /// As a part of the newest step, when that replaced the same values, for the same client and purpose, less
  /// than a minute ago: it is the newer revision then, and what was before the first of them is before it.
  void join(SettingsStep step);
  const SettingsStep* find(std::uint64_t revision) const;
  /// Newest first, those after a revision.
  Json newer_than(std::uint64_t revision) const;
  Json to_json() const { return steps_; }

 private:
  std::vector<SettingsStep> steps_;  // oldest first
  std::vector<std::size_t> sizes_;
  std::size_t bytes_ = 0;
};

}  // namespace sslv
