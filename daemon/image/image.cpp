// SPDX-License-Identifier: Apache-2.0
#include "image/image.h"

#include "image/pixel_format_names.h"

namespace sslv {

std::string_view name_of(PixelFormat format) {
  for (const NamedPixelFormat& named : kPixelFormatNames) {
    if (named.format == format) return named.name;
  }
  return "unknown";
}

std::optional<PixelFormat> pixel_format_named(std::string_view name) {
  for (const NamedPixelFormat& named : kPixelFormatNames) {
    if (named.name == name) return named.format;
  }
  return std::nullopt;
}

bool is_valid_size(PixelFormat format, int width, int height) {
  constexpr int kMaxSide = 16384;
  if (width < 2 || height < 2 || width > kMaxSide || height > kMaxSide) return false;
  if ((is_yuv422(format) || is_bayer(format)) && width % 2 != 0) return false;
  return !is_bayer(format) || height % 2 == 0;
}

}  // namespace sslv
