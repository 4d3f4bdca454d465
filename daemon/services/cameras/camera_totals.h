// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/duration_totals.h"
#include "capture/camera_thread.h"
#include "config/stages.h"
#include "pipeline/validate.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace sslv {

/// Counters of a camera id over the life of the process: they continue if the camera is reopened, gets
/// another stack, or is removed from the settings and added again. Incremented without a lock.
struct CameraTotals {
  CaptureTotals capture;
  std::atomic<std::uint64_t> frames{0};                                   // captured
  std::atomic<std::uint64_t> robots_yellow{0}, robots_blue{0}, balls{0};  // sent
  DurationTotals capture_to_send;
  std::vector<DurationTotals> stages{stage_table().size()};   // by row of the stage table
  std::vector<InvalidTotals> left_out{stage_table().size()};  // by row of the stage table
};

}  // namespace sslv
