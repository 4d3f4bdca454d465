// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sslv {

/// A test image: width x height pixels of three bytes.
struct RgbPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb{};
  bool operator==(const RgbPicture&) const = default;
};

/// Writes a file in the format of its extension: .png, .bmp, .ppm (one image), .mkv (lossless video) or .mp4
/// (lossy video). Throws std::runtime_error.
void write_media(const std::string& path, const std::vector<RgbPicture>& pictures, int rate_hz = 25);

}  // namespace sslv
