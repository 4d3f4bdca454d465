// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "capture/controls.h"
#include "services/cameras/driver_calls.h"

#include <atomic>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// Controls of an open camera that were set already, before the settings which say so take effect: unless
/// they are kept, the destructor sets them back. What is no longer among the settings gets the value back
/// that it had when the camera was opened; a mode that goes back takes with it what it has changed.
class ControlChange {
 public:
  /// Nothing is set.
  ControlChange() = default;
  /// Sets all of `wanted` that differ from `before`. Throws SettingsError, beginning with `path`, when the
  /// camera refuses one or does not answer; then all are as they were, or will be once it answers.
  ControlChange(std::shared_ptr<Controls> controls, DriverCalls calls, const Json& before, const Json& wanted,
                const std::string& path);
  ControlChange(ControlChange&&) = default;
  ControlChange& operator=(ControlChange&&) = delete;
  ~ControlChange();

  void keep() noexcept;
  /// Some take effect only when the camera is reopened.
  bool needs_opening() const { return set_ && set_->needs_opening; }
  /// The ones among them that are no longer in the settings: the values to open the camera with.
  Json at_opening() const { return set_ ? set_->at_opening : Json::object(); }

 private:
  struct Set {
    std::shared_ptr<Controls> controls;
    Json changed = Json::object();     // name -> value that is wanted from now on
    Json unchanged = Json::object();   // that was wanted already
    Json restored = Json::object();    // no longer wanted: name -> value before it was
    Json at_opening = Json::object();  // of these
    std::vector<std::pair<std::string, Json>> old_values;
    bool needs_opening = false, has_gone_back = false;  // a mode has
    enum class Phase { kSetting, kDone, kAbandoned };
    std::atomic<Phase> phase = Phase::kSetting;

    /// Throws SettingsError when one of `changed` is refused.
    void set_all();
    void set(const Control& control, const Json& value, bool is_wanted);
    /// Sets back what the modes that went back have changed; whether there was any.
    bool restore_others();
    void set_back() noexcept;
  };

  DriverCalls calls_;
  std::shared_ptr<Set> set_;  // null: nothing to set back
};

}  // namespace sslv
