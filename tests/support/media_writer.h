// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sslv {

/// A picture of a test: width x height pixels, three bytes each.
struct RgbPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb{};
  bool operator==(const RgbPicture&) const = default;
};

/// Writes a file as its ending says: .png, .bmp, .ppm (one picture), .mkv (a lossless video) or .mp4 (a lossy
/// one). Throws std::runtime_error.
void write_media(const std::string& path, const std::vector<RgbPicture>& pictures, int rate_hz = 25);

}  // namespace sslv
