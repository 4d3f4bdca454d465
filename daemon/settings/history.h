// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sslv {

/// One step of the settings' history, as saved and shown: {"revision": 7, "time": 1790000000.1, "who":
/// "192.168.1.5", "what": "", "changes": [{"op": "replace", "path": "/site", "before": "A", "after": "B"}]}.
/// "op" is "add", "remove" or "replace"; "time" is Unix time in seconds, "what" names the operation that the
/// step was part of.
using SettingsStep = Json;

/// Returns the changes that turn one tree into another, value by value.
Json changes_between(const Json& before, const Json& after);

/// Returns the changes at or below one of these JSON Pointers.
Json changes_below(const Json& changes, const std::vector<std::string>& paths);

/// Return a JSON Patch that makes these changes, and one that reverts them.
Json forward_patch(const Json& changes);
Json backward_patch(const Json& changes);

/// Returns a JSON Patch that turns `before` into exactly `after`. It includes differences that Json::diff()
/// ignores: another order of keys in free objects, and 1.0 instead of 1.
Json exact_patch(const Json& before, const Json& after);

/// Throws SettingsError unless `steps` has the form that SettingsHistory::newer_than() returns and its first
/// step is not newer than `revision`.
void check_steps(const Json& steps, std::uint64_t revision);

/// The newest steps, limited in number and bytes.
class SettingsHistory {
 public:
  static constexpr std::size_t kMaxSteps = 300, kMaxBytes = 512 * 1024;

  SettingsHistory() = default;
  /// Reads what to_json() returned; ignores everything that is not a step.
  explicit SettingsHistory(const Json& saved);

  void add(SettingsStep step);
  /// Adds a step, or merges it with the newest step if that step replaced the same values for the same client
  /// and purpose less than a minute ago: the result has the newer revision and the earlier "before" values.
  void join(SettingsStep step);
  const SettingsStep* find(std::uint64_t revision) const;
  /// The steps after a revision, newest first.
  Json newer_than(std::uint64_t revision) const;
  Json to_json() const { return steps_; }

 private:
  std::vector<SettingsStep> steps_;  // oldest first
  std::vector<std::size_t> sizes_;
  std::size_t bytes_ = 0;
};

}  // namespace sslv
