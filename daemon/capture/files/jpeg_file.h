// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/files/picture_pool.h"

#include <string>

namespace sslv {

/// The image of a JPEG file, as JpegDecoder gives it (uyvy or rgb24). Throws std::runtime_error with the
/// reason, without the path, when it cannot be read, is none or is damaged.
Image read_jpeg_file(const std::string& path, PicturePool& pool);

}  // namespace sslv
