// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/aravis/aravis_library.h"
#include "image/image.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace sslv {

/// A camera's pixel format (GenICam Pixel Format Naming Convention) and the pipeline's format for it.
struct AravisFormat {
  ArvPixelFormat arv = 0;
  PixelFormat format{};
  /// Converts 8-bit pixels; null if no conversion is needed.
  void (*unpack)(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept = nullptr;
  /// Splits pixels of more than 8 bits: `to` gets the upper 8 bits, `low` the bits below. Null for 8-bit
  /// formats.
  void (*split)(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                std::uint8_t* low) noexcept = nullptr;

  /// Whether pixels must be converted into another buffer. Otherwise they are used in the camera's buffer.
  bool is_copied() const { return unpack != nullptr || split != nullptr; }
};

/// Null for unsupported formats.
const AravisFormat* find_aravis_format(ArvPixelFormat arv);

/// The camera's format with the same memory layout, so that no conversion is needed.
ArvPixelFormat arv_format_of(PixelFormat format);

/// Bytes of a row as sent, without padding; packed rows of odd length share a byte.
inline std::size_t sent_bytes(const AravisFormat& format, std::size_t pixels) {
  return (pixels * ARV_PIXEL_FORMAT_BIT_PER_PIXEL(format.arv) + 7) / 8;
}

}  // namespace sslv
