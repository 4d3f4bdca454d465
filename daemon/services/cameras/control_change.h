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
/// they are kept, the destructor sets them back.
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

 private:
  struct Set {
    std::shared_ptr<Controls> controls;
    std::vector<std::pair<std::string, Json>> old_values;
    bool needs_opening = false;
    enum class Phase { kSetting, kDone, kAbandoned };
    std::atomic<Phase> phase = Phase::kSetting;
    void set_back() noexcept;
  };

  DriverCalls calls_;
  std::shared_ptr<Set> set_;  // null: nothing to set back
};

}  // namespace sslv
