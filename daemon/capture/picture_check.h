// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/frame_info.h"
#include "image/image.h"

#include <string>

namespace sslv {

// What a driver hands over is looked at before the pipeline relies on it.

/// Why this is no image; empty when it is one.
std::string find_fault(const ImageView& picture);

/// Takes the moment it is handed over for an image whose time cannot be: no number, in the future, or so old
/// that a clock was set meanwhile. Says whether it was so.
bool mend_times(CaptureTimes& times, double now_s);

}  // namespace sslv
