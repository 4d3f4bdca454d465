// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/aravis/aravis_library.h"
#include "image/image.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace sslv {

/// How a camera sends pixels (GenICam Pixel Format Naming Convention), and what they are to the pipeline.
struct AravisFormat {
  ArvPixelFormat arv = 0;
  PixelFormat format{};
  /// Makes the one into the other; null: they are the same.
  void (*unpack)(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept = nullptr;
};

/// Null: none that we read.
const AravisFormat* find_aravis_format(ArvPixelFormat arv);

/// What a camera that sends this format as it is calls it.
ArvPixelFormat arv_format_of(PixelFormat format);

/// Bytes of a row as the camera sends it, without padding; packed rows of odd length share a byte.
inline std::size_t sent_bytes(const AravisFormat& format, std::size_t pixels) {
  return (pixels * ARV_PIXEL_FORMAT_BIT_PER_PIXEL(format.arv) + 7) / 8;
}

}  // namespace sslv
