// SPDX-License-Identifier: Apache-2.0
#include "control_change.h"

#include "base/error.h"
#include "base/log.h"

#include <exception>

namespace sslv {

ControlChange::ControlChange(std::shared_ptr<Controls> controls, const Json& before, const Json& wanted,
                             const std::string& path)
    : controls_(std::move(controls)) {
  for (const auto& [name, value] : wanted.items()) {
    if (before.contains(name) && before.at(name) == value) continue;
    try {
      const Json old = controls_->get(name).value;
      if (controls_->set(name, value) == ControlEffect::kWhenOpened) needs_opening_ = true;
      set_.emplace_back(name, old);
    } catch (const std::exception& error) {
      set_back();
      throw SettingsError(path + '/' + error.what());
    }
  }
}

ControlChange::~ControlChange() {
  set_back();
}

void ControlChange::set_back() noexcept {
  for (; !set_.empty(); set_.pop_back()) {
    const auto& [name, value] = set_.back();
    try {
      if (!value.is_null()) controls_->set(name, value);
    } catch (const std::exception& error) {
      log::warning("not set back: {}", error.what());
    }
  }
}

}  // namespace sslv
