// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Decodes a camera's JPEGs, also Motion-JPEG without Huffman tables. Reuses its buffers, so use one decoder
/// for many images; one thread at a time.
class JpegDecoder {
 public:
  JpegDecoder();
  ~JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  /// Size, stride and format that decode() will write; the data is null. The format is uyvy for images with
  /// colour at half the width, which cameras usually send, otherwise rgb24. The size is 0, with the reason in
  /// `problem`, if the bytes are not a JPEG or the image's size is not supported.
  ImageView layout(std::span<const std::uint8_t> jpeg, std::string& problem);

  /// Decodes the image of the last layout() call. Returns false, with the reason, if the image is damaged.
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
