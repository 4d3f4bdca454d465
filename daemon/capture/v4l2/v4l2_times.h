// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/frame_info.h"

#include <cstdint>
#include <optional>

namespace sslv {

/// What a driver's time stamp is the moment of.
enum class V4l2StampedAt : std::uint8_t {
  kArrival,        // nothing is known but when the image was fetched
  kExposureStart,  //
  kExposureEnd,    // about: when the image's first bytes came
  kPictureEnd,     // when its last bytes came
};

struct V4l2Timing {
  V4l2StampedAt stamped_at = V4l2StampedAt::kArrival;
  std::optional<double> exposure_s{};  // none: not known, as with automatic exposure
  double period_s = 0;                 // between images; 0: not known
};

/// `stamp_s` on the host's Unix clock.
CaptureTimes capture_times(double stamp_s, const V4l2Timing& timing);

/// From the flags of a buffer (V4L2_BUF_FLAG_*).
V4l2StampedAt stamped_at(std::uint32_t buffer_flags, bool stamps_first_bytes);

}  // namespace sslv
