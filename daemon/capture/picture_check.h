// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/frame_info.h"
#include "image/image.h"

#include <string>

namespace sslv {

// What a driver hands over is looked at before the pipeline relies on it.

/// Why this is no image; empty when it is one.
std::string find_fault(const ImageView& picture);

/// Replaces an impossible time of an image by the current one: no number, in the future, or so old that a
/// clock was set meanwhile. Returns whether it did.
bool sanitize_times(CaptureTimes& times, double now_s);

}  // namespace sslv
