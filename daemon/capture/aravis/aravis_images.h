// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/aravis/aravis_formats.h"
#include "capture/aravis/aravis_library.h"
#include "capture/buffer_pool.h"
#include "image/frame_info.h"
#include "image/image.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sslv {

/// A sound image in the library's buffer.
struct SentPicture {
  const AravisFormat* format = nullptr;
  const std::uint8_t* data = nullptr;
  int width = 0, height = 0;
  std::size_t padding_bytes = 0;  // at the end of each row
};

/// The view of an image that needs no unpacking.
ImageView view_of(const SentPicture& sent);

/// What a camera, or a stranger in its name, says of an image in a buffer.
struct ClaimedPicture {
  ArvPixelFormat format = 0;
  int width = 0, height = 0;
  int padding_bytes = 0;                // at the end of each row
  std::uintptr_t offset = 0;            // of the image in the buffer
  std::size_t bytes = 0;                // of the image
  std::size_t came = 0, allocated = 0;  // of the whole buffer: what came in packets, and what there is
};

/// The image, its data beginning at `begin` of the buffer, if all of it came and lies in the buffer. Else no
/// format, with the reason.
SentPicture sound_picture(const ClaimedPicture& claimed, const std::uint8_t* begin, std::string& problem);

/// Finds the image in a buffer.
class AravisBufferReader {
 public:
  /// `use_incomplete`: also images that lack packets.
  explicit AravisBufferReader(bool use_incomplete) : use_incomplete_(use_incomplete) {}

  /// Of all that it is given.
  void set_buffer_bytes(std::size_t bytes) { buffer_bytes_ = bytes; }
  /// Whether no more came than there is room for, as the library counts.
  bool is_within(ArvBuffer* buffer) const;

  /// Asks the camera which part of its sensor is read. One without these features is taken for whole. Throws
  /// CaptureError, with the camera's label, if it does not answer.
  void read_region(ArvCamera* camera, std::string_view label);
  const WholePicture& whole() const { return whole_; }

  /// No format, with the reason, when the buffer holds no sound image.
  SentPicture picture_in(ArvBuffer* buffer, std::string& problem);

 private:
  SentPicture damaged_picture_in(ArvBuffer* buffer) const;

  const bool use_incomplete_;
  std::size_t buffer_bytes_ = 0;
  WholePicture whole_;
  SentPicture last_whole_;                // its data is not used
  std::ptrdiff_t last_whole_offset_ = 0;  // of the image in its buffer
};

/// Unpacks images into buffers of ours, so that the camera has its own back at once.
class AravisUnpacker {
 public:
  explicit AravisUnpacker(int buffers) : buffers_(buffers) {}

  /// False when viewers hold all our buffers.
  bool unpack(const SentPicture& sent, Image& image);

  /// Images that there was no buffer for.
  std::uint64_t dropped() const { return dropped_; }

 private:
  const int buffers_;
  std::optional<BufferPool> pool_;
  std::size_t pool_bytes_ = 0;  // of each
  std::uint64_t dropped_ = 0;
};

}  // namespace sslv
