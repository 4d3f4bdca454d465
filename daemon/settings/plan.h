// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace sslv {

/// Applies a change that is already saved. All steps that can fail or take long were done before, so Apply
/// cannot fail; the compiler checks this.
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

/// The steps of a settings change, in the order of execution. Making a plan has no effect and queries no
/// device; a dry run ends there.
struct Plan {
  /// Acquires resources of the service that may be unavailable: threads, sockets, processes. They are
  /// released with the plan. Throws SettingsError; nothing has changed then.
  std::function<void()> get_ready = [] {};
  /// Called once the settings are saved; waits for no device.
  Apply apply{};
  /// Waits for the devices and returns a line for each setting that they refused, beginning with the
  /// setting's path.
  std::function<std::vector<std::string>()> outcome = [] { return std::vector<std::string>(); };
};

}  // namespace sslv
