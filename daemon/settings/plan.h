// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace sslv {

/// Makes a change take effect that is saved. All that can fail or takes long was done before, so it cannot
/// fail, which the compiler checks.
class Apply {
 public:
  /// Nothing to do.
  Apply() = default;
  template <class Act>
  requires(!std::is_same_v<std::remove_cvref_t<Act>, Apply>) Apply(Act act) : act_(std::move(act)) {
    static_assert(std::is_nothrow_invocable_v<Act&>, "what applies a change must be noexcept");
  }
  void operator()() const noexcept {
    if (act_) act_();
  }

 private:
  std::function<void()> act_;
};

/// What a change of settings will do, in the order in which it is done. To make a plan has no effect and asks
/// no device anything; a dry run ends there.
struct Plan {
  /// Takes what belongs to the service and may not be had: threads, sockets, processes. What was taken goes
  /// with the plan. Throws SettingsError, and nothing has changed.
  std::function<void()> get_ready = [] {};
  /// Once the settings are saved; waits for no device.
  Apply apply{};
  /// Waits for what devices have refused of it: a line for each, beginning with its place in the settings.
  std::function<std::vector<std::string>()> outcome = [] { return std::vector<std::string>(); };
};

}  // namespace sslv
