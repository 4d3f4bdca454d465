// SPDX-License-Identifier: Apache-2.0
#include "base/background_jobs.h"

namespace sslv {

const char* name_of(JobState state) {
  switch (state) {
    case JobState::kIdle: return "idle";
    case JobState::kCollecting: return "collecting";
    case JobState::kSolving: return "solving";
    case JobState::kDone: return "done";
    case JobState::kFailed: return "failed";
    case JobState::kCancelled: break;
  }
  return "cancelled";
}

}  // namespace sslv
