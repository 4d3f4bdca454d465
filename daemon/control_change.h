// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "capture/controls.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// Controls of an open camera that were set already, before the settings which say so are in force: unless
/// they are kept, the destructor sets them back.
class ControlChange {
 public:
  /// Nothing is set.
  ControlChange() = default;
  /// Sets all of `wanted` that differ from `before`. Throws SettingsError, beginning with `path`, when the
  /// camera refuses one; then all are as they were.
  ControlChange(std::shared_ptr<Controls> controls, const Json& before, const Json& wanted,
                const std::string& path);
  ControlChange(ControlChange&&) = default;
  ControlChange& operator=(ControlChange&&) = delete;
  ~ControlChange();

  void keep() { set_.clear(); }
  /// Some take force only when the camera is opened anew.
  bool needs_opening() const { return needs_opening_; }

 private:
  void set_back() noexcept;

  std::shared_ptr<Controls> controls_;
  std::vector<std::pair<std::string, Json>> set_;  // with their old values
  bool needs_opening_ = false;
};

}  // namespace sslv
