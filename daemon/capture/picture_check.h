// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/frame_info.h"
#include "image/image.h"

#include <string>

namespace sslv {

// Validation of a driver's images, before the pipeline relies on them.

/// Why the image is not valid; empty if it is valid.
std::string find_fault(const ImageView& picture);

/// Replaces an impossible capture time (NaN, in the future, or so old that a clock must have been set) by the
/// current time. Returns whether the time was replaced.
bool sanitize_times(CaptureTimes& times, double now_s);

}  // namespace sslv
