// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

namespace sslv {

/// Runs calls to a camera's driver, or to other code that may hang and cannot be interrupted, one at a time
/// in a background thread that exists while calls are pending. Limits the wait for a call. Abandons a call
/// that hangs, and refuses later calls quickly, so that they do not block the callers' threads. Copies refer
/// to the same camera. Thread-safe.
class DriverCalls {
 public:
  static constexpr std::chrono::milliseconds kPatience{5000}, kPatienceWithOthers{2000};

  explicit DriverCalls(std::chrono::milliseconds patience = kPatience,
                       std::chrono::milliseconds patience_with_others = kPatienceWithOthers);

  /// Runs `call`, which must own all it uses, and returns its result. Throws the exceptions of `call`, and
  /// CaptureError if `call` does not return in time, or if an earlier call still hangs (then `call` is not
  /// run).
  template <class Act>
  auto run(Act call) const {
    const auto result = std::make_shared<std::optional<std::invoke_result_t<Act&>>>();
    run_in_turn([result, act = std::move(call)]() mutable { result->emplace(act()); });
    return std::move(**result);
  }

  struct Call;
  using Posted = std::shared_ptr<Call>;
  /// Queues `call` without waiting. Throws std::system_error if no thread can be created.
  Posted post(std::function<void()> call) const;
  /// Waits until the call has run. Throws the call's exception, and CaptureError if that takes too long; the
  /// call then keeps running.
  void wait(const Posted& call) const;

  /// Call when the program ends: current and later waits and calls throw CaptureError.
  void ask_to_stop() const;

 private:
  struct Shared;
  void run_in_turn(std::function<void()> call) const;

  std::shared_ptr<Shared> shared_;
};

}  // namespace sslv
