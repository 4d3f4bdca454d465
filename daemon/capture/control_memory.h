// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "base/json.h"
#include "capture/controls.h"

#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sslv {

/// A control that was set and not saved.
struct UnsavedControl {
  Control control;  // as it was last read
  Json before;      // what the camera had before
};

/// It takes effect only when the camera is reopened, so it cannot be set without saving it.
struct NeedsReopening : SettingsError {
  using SettingsError::SettingsError;
};

/// What an open camera had before its controls were set. It lives with them; a camera that is reopened and
/// kept its values inherits it. The functions that talk to the camera are for one thread at a time; the
/// others for any.
class ControlMemory {
 public:
  /// `controls` must outlive this.
  explicit ControlMemory(Controls& controls) : controls_(controls) {}

  /// Sets one (or does an action) and remembers what it was; also the modes that the camera changed with it.
  /// Throws what Controls::set() throws, and NeedsReopening.
  Control set_unsaved(const std::string& name, const Json& value);
  /// Sets unsaved controls back to what they were, the newest first; `names` empty: all. With a mode also
  /// what it has changed since. Throws SettingsError when the camera refuses; the others are set back.
  void revert(const std::set<std::string>& names);
  /// Reads all controls, unless that was done since the opening: what the camera has before a change.
  void read_once();
  /// Once the saved controls are set at an opening: takes over from the opening before what the camera still
  /// has as it was left. Throws CaptureError.
  void inherit(const ControlMemory& before);

  /// All that the camera has now, as the caller has read it.
  void update(const std::vector<Control>& now);
  /// `values` (name -> value) are saved now.
  void forget(const Json& values);
  /// Those that differ both from what they were and from what is saved (name -> value).
  std::vector<UnsavedControl> unsaved(const Json& saved) const;

  /// A control is about to be set; the first time counts.
  void note_first(const Control& before);
  /// None: not known.
  std::optional<Json> when_opened(const std::string& name) const;
  /// Values that a mode which goes back to what it was at the opening may have changed: name -> value then.
  Json others_when_opened(const std::set<std::string>& except) const;

 private:
  using Values = std::map<std::string, Json>;

  /// Sets what differs from `targets`: values first, then modes, because a value may end a mode, and a mode
  /// may lock a value. What was refused, by name.
  Values set_all(const Values& targets);
  void update_one(const Control& now);
  UnsavedControl* find(const std::string& name);

  Controls& controls_;
  mutable std::mutex mutex_;             // guards all that follows
  Values first_, opened_, clean_;        // before each one's first set, before any, before those unsaved
  std::vector<UnsavedControl> entries_;  // in the order in which they were first set
  bool was_read_ = false;
};

/// A mode: what may change other controls, such as an automatic.
inline bool is_mode(const Control& control) {
  return control.kind == ControlKind::kChoice || control.kind == ControlKind::kFlag;
}

}  // namespace sslv
