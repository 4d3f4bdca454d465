// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/buffer_pool.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace sslv {

/// A BufferPool for pictures whose size is known only once they come.
class PicturePool {
 public:
  /// Allocates only when a picture is larger than any before; low bits (`is_deep`) lie right behind it.
  /// Throws std::runtime_error when all buffers are out.
  Image take(PixelFormat format, int width, int height, std::uint8_t*& pixels, bool is_deep = false);

 private:
  std::optional<BufferPool> buffers_;
  std::size_t bytes_each_ = 0;
};

/// The pictures of one picture or video file as rgb24, decoded by FFmpeg's libraries.
class MediaReader {
 public:
  enum class Result { kPicture, kDamaged, kEnd };

  /// Throws std::runtime_error with the reason, without the path. A `still` picture must be sound to its last
  /// byte; in a video decoders may do without parts of the stream.
  MediaReader(const std::string& path, bool still);
  ~MediaReader();

  /// Pictures a second as the file says; 0 when it does not.
  double frame_rate_hz() const;

  /// How many pictures the file says it has, or would have by its length; 0 when it does not say.
  std::int64_t count() const;
  /// The next picture will be this one, counted from 0. Reads through the whole file the first time. Throws
  /// std::runtime_error.
  void seek(std::int64_t picture);
  /// Of the last picture, on the file's clock.
  std::optional<double> time_s() const;

  /// The next picture. For kDamaged `problem` says why; the next call goes on behind the damage.
  Result read(PicturePool& pool, Image& image, std::string& problem);

 private:
  struct Libraries;
  std::unique_ptr<Libraries> av_;
};

}  // namespace sslv
