// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Reads the JPEGs of a camera (Motion-JPEG, also without the tables that it leaves out). Keeps its buffers,
/// so use one for many images; one thread at a time.
class JpegDecoder {
 public:
  JpegDecoder();
  ~JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  /// Size, stride and format that decode() will write, its data null: uyvy for images that keep the colour
  /// at half the width or less, as cameras do, since that is what they hold; else rgb24. A size of 0, with
  /// the reason in `problem`, when it is no JPEG.
  ImageView layout(std::span<const std::uint8_t> jpeg, std::string& problem);

  /// Writes the image of which layout() was asked last. False, with the reason, when it is damaged.
  bool decode(std::span<const std::uint8_t> jpeg, std::uint8_t* out, std::string& problem);

 private:
  void start();
  void give_up(std::string& problem);
  bool decode_uyvy(std::span<const std::uint8_t> jpeg, std::uint8_t* out);

  void* handle_ = nullptr;
  ImageView layout_{};
  int subsampling_ = 0;
  std::vector<std::uint8_t> planes_;
};

}  // namespace sslv
