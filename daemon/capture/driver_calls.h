// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

namespace sslv {

/// Calls of a camera's driver, or of what else nobody can interrupt, which may hang: one after the other, in
/// a thread of their own that is there while they last. Each is waited for only so long. One that hangs is
/// left behind, and those after it are refused soon, so that they cannot use up the threads of the callers.
/// Copies are of the same camera. May be used from any thread.
class DriverCalls {
 public:
  static constexpr std::chrono::milliseconds kPatience{5000}, kPatienceWithOthers{2000};

  explicit DriverCalls(std::chrono::milliseconds patience = kPatience,
                       std::chrono::milliseconds patience_with_others = kPatienceWithOthers);

  /// Runs `call`, which must own all it uses, and returns what it returns. Throws what it throws, and
  /// CaptureError when it does not return in time or another one still has not: then it is not run.
  template <class Act>
  auto run(Act call) const {
    const auto result = std::make_shared<std::optional<std::invoke_result_t<Act&>>>();
    run_in_turn([result, act = std::move(call)]() mutable { result->emplace(act()); });
    return std::move(**result);
  }

  struct Call;
  using Posted = std::shared_ptr<Call>;
  /// Runs `call` when its turn comes and does not wait for that. Throws std::system_error when there is no
  /// thread to be had.
  Posted post(std::function<void()> call) const;
  /// Until it has been run. Throws what it has thrown, and CaptureError when that takes too long; it is run
  /// all the same then.
  void wait(const Posted& call) const;

  /// The program ends: nobody waits for an answer any more, now or later; all throws CaptureError.
  void ask_to_stop() const;

 private:
  struct Shared;
  void run_in_turn(std::function<void()> call) const;

  std::shared_ptr<Shared> shared_;
};

}  // namespace sslv
