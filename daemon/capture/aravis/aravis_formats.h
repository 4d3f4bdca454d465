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
  /// Makes the one into the other.
  void (*unpack)(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to) noexcept = nullptr;
  /// The same of more than 8 bits, whose rest goes to `low`.
  void (*split)(const std::uint8_t* from, std::size_t pixels, std::uint8_t* to,
                std::uint8_t* low) noexcept = nullptr;

  /// Else the camera's bytes are read where they are.
  bool is_copied() const { return unpack != nullptr || split != nullptr; }
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
