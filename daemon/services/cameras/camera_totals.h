// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/duration_totals.h"
#include "capture/camera_thread.h"
#include "config/stages.h"
#include "pipeline/senseless.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace sslv {

/// What is counted of a camera id as long as the process lives: also when the camera is reopened, has
/// another stack, or is taken out of the settings and comes back. Counted without a lock.
struct CameraTotals {
  CaptureTotals capture;
  std::atomic<std::uint64_t> frames{0};                                   // captured
  std::atomic<std::uint64_t> robots_yellow{0}, robots_blue{0}, balls{0};  // sent
  DurationTotals capture_to_send;
  std::vector<DurationTotals> stages{stage_table().size()};     // as in the table
  std::vector<SenselessTotals> left_out{stage_table().size()};  // likewise
};

}  // namespace sslv
