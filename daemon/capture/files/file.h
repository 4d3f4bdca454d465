// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

namespace sslv {

/// "files": recorded images (PNG, JPEG, BMP, PPM), raw frames or a video instead of a camera.
Backend file_backend();

}  // namespace sslv
