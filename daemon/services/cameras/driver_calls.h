// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <chrono>
#include <functional>
#include <memory>

namespace sslv {

/// Calls of a camera's driver, or of what else nobody can interrupt, which may hang: one at a time, each in a
/// thread of its own and waited for only so long. One that hangs is left behind, and those after it are
/// refused soon, so that they cannot use up the threads of the callers. Copies are of the same camera. May be
/// used from any thread.
class DriverCalls {
 public:
  static constexpr std::chrono::milliseconds kPatience{5000}, kPatienceWithOthers{500};

  explicit DriverCalls(std::chrono::milliseconds patience = kPatience,
                       std::chrono::milliseconds patience_with_others = kPatienceWithOthers);

  /// Runs `call`, which must own all it uses, and returns what it returns. Throws what it throws, and
  /// CaptureError when it does not return in time or another one still has not.
  Json run(std::function<Json()> call) const;

  /// The camera is closed: nobody waits for an answer any more, now or later; run() throws CaptureError.
  void ask_to_stop() const;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace sslv
