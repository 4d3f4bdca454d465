// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/files/picture_pool.h"

#include <string>

namespace sslv {

/// The image of a JPEG file, as JpegDecoder delivers it (uyvy or rgb24). Throws std::runtime_error with the
/// reason, without the path, if the file cannot be read, is not a JPEG or is damaged.
Image read_jpeg_file(const std::string& path, PicturePool& pool);

}  // namespace sslv
