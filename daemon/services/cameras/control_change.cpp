// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/control_change.h"

#include "base/error.h"
#include "base/log.h"
#include "capture/source.h"

#include <exception>

namespace sslv {

ControlChange::ControlChange(std::shared_ptr<Controls> controls, DriverCalls calls, const Json& before,
                             const Json& wanted, const std::string& path)
    : calls_(std::move(calls)), set_(std::make_shared<Set>()) {
  Json changed = Json::object();
  for (const auto& [name, value] : wanted.items()) {
    if (!before.contains(name) || before.at(name) != value) changed[name] = value;
  }
  set_->controls = std::move(controls);
  if (changed.empty()) return;
  try {
    // It sets back by itself what it has set before one is refused, also when nobody waits for it any more.
    calls_.run([set = set_, changed, path]() -> Json {
      for (const auto& [name, value] : changed.items()) {
        try {
          const Json old = set->controls->get(name).value;
          if (set->controls->set(name, value) == ControlEffect::kWhenOpened) set->needs_opening = true;
          set->old_values.emplace_back(name, old);
        } catch (const std::exception& error) {
          set->set_back();
          throw SettingsError(path + '/' + error.what());
        }
      }
      if (set->phase.exchange(Set::Phase::kDone) == Set::Phase::kAbandoned) set->set_back();
      return {};
    });
  } catch (const CaptureError& error) {
    if (set_->phase.exchange(Set::Phase::kAbandoned) == Set::Phase::kDone) set_->set_back();
    throw SettingsError(path + ": not set: " + error.what());
  }
}

ControlChange::~ControlChange() {
  if (!set_ || set_->old_values.empty()) return;
  try {
    calls_.run([set = std::move(set_)]() -> Json {
      set->set_back();
      return {};
    });
  } catch (const std::exception& error) {
    log::warning("controls not set back: {}", error.what());
  }
}

void ControlChange::keep() noexcept {
  if (set_) set_->old_values.clear();
}

void ControlChange::Set::set_back() noexcept {
  for (; !old_values.empty(); old_values.pop_back()) {
    const auto& [name, value] = old_values.back();
    try {
      if (!value.is_null()) controls->set(name, value);
    } catch (const std::exception& error) {
      log::warning("not set back: {}", error.what());
    }
  }
}

}  // namespace sslv
