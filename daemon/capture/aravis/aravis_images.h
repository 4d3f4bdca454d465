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

/// A valid image in the library's buffer.
struct SentPicture {
  const AravisFormat* format = nullptr;
  const std::uint8_t* data = nullptr;
  int width = 0, height = 0;
  std::size_t padding_bytes = 0;  // at the end of each row
};

/// The view of an image that needs no unpacking.
ImageView view_of(const SentPicture& sent);

/// An image's properties as claimed by a camera, or by another computer that sends in the camera's name.
struct ClaimedPicture {
  ArvPixelFormat format = 0;
  int width = 0, height = 0;
  int padding_bytes = 0;                // at the end of each row
  std::uintptr_t offset = 0;            // start of the image in the buffer
  std::size_t bytes = 0;                // size of the image
  std::size_t came = 0, allocated = 0;  // bytes of the buffer: received in packets; allocated
};

/// Validates the claimed image, whose buffer starts at `begin`: it must be complete and within the buffer. If
/// it is not, returns no format and sets `problem` to the reason.
SentPicture sound_picture(const ClaimedPicture& claimed, const std::uint8_t* begin, std::string& problem);

/// Finds the image in a buffer.
class AravisBufferReader {
 public:
  /// `use_incomplete`: also use images with missing packets.
  explicit AravisBufferReader(bool use_incomplete) : use_incomplete_(use_incomplete) {}

  /// The allocated size of every buffer.
  void set_buffer_bytes(std::size_t bytes) { buffer_bytes_ = bytes; }
  /// Whether the received bytes, as counted by the library, fit into the buffer.
  bool is_within(ArvBuffer* buffer) const;

  /// Reads the region of the sensor that the camera transmits. A camera without features for the region is
  /// assumed to transmit the whole sensor. Throws CaptureError, with the camera's label, if the camera does
  /// not answer.
  void read_region(ArvCamera* camera, std::string_view label);
  const WholePicture& whole() const { return whole_; }

  /// Returns no format, and sets `problem` to the reason, if the buffer holds no valid image.
  SentPicture picture_in(ArvBuffer* buffer, std::string& problem);

 private:
  SentPicture damaged_picture_in(ArvBuffer* buffer) const;

  const bool use_incomplete_;
  std::size_t buffer_bytes_ = 0;
  WholePicture whole_;
  SentPicture last_whole_;                // last complete image; its data pointer is unused
  std::ptrdiff_t last_whole_offset_ = 0;  // start of that image in its buffer
};

/// Converts images into our own buffers, so that the camera's buffers are returned at once.
class AravisUnpacker {
 public:
  explicit AravisUnpacker(int buffers) : buffers_(buffers) {}

  /// False if viewers hold all our buffers.
  bool unpack(const SentPicture& sent, Image& image);

  /// Images dropped for lack of a buffer.
  std::uint64_t dropped() const { return dropped_; }

 private:
  const int buffers_;
  std::optional<BufferPool> pool_;
  std::size_t pool_bytes_ = 0;  // size of each buffer
  std::uint64_t dropped_ = 0;
};

}  // namespace sslv
