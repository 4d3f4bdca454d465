// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/frame_info.h"

#include <cstdint>
#include <optional>

namespace sslv {

/// The moment to which a driver's time stamp refers.
enum class V4l2StampedAt : std::uint8_t {
  kArrival,  // unknown; only the time of fetching is known
  kExposureStart,
  kExposureEnd,  // approximately: arrival of the image's first bytes
  kPictureEnd,   // arrival of the image's last bytes
};

struct V4l2Timing {
  V4l2StampedAt stamped_at = V4l2StampedAt::kArrival;
  std::optional<double> exposure_s{};  // empty if unknown, as with automatic exposure
  double period_s = 0;                 // time between images; 0: unknown
};

/// Capture times for a stamp on the host's Unix clock: the middle of the exposure, or with kArrival the stamp
/// itself.
CaptureTimes capture_times(double stamp_s, const V4l2Timing& timing);

/// The meaning of a buffer's stamp, from its flags (V4L2_BUF_FLAG_*).
V4l2StampedAt stamped_at(std::uint32_t buffer_flags, bool stamps_first_bytes);

}  // namespace sslv
