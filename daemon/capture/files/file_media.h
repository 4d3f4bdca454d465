// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/files/picture_pool.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace sslv {

/// The images of one image or video file, decoded by FFmpeg's libraries, as rgb24. Without them
/// (file_media_jpeg.cpp) only JPEGs can be read.
class MediaReader {
 public:
  enum class Result { kPicture, kDamaged, kEnd, kSearching };
  using Clock = std::chrono::steady_clock;

  /// Throws std::runtime_error with the reason, without the path. A `still` image must be sound to its last
  /// byte; in a video decoders may do without parts of the stream.
  MediaReader(const std::string& path, bool still);
  ~MediaReader();

  /// Images a second as the file says; 0 when it does not.
  double frame_rate_hz() const;

  /// How many images the file says it has, or would have by its length; 0 when it does not say.
  std::int64_t count() const;
  /// The next image will be this one, counted from 0. Reads through the whole file the first time. False: it
  /// was not done at `until`, and nothing can be read before it is; the next call goes on. Throws
  /// std::runtime_error.
  bool seek(std::int64_t picture, Clock::time_point until);
  /// Of the last image, on the file's clock.
  std::optional<double> time_s() const;

  /// The next image. For kDamaged `problem` says why; the next call goes on behind the damage. kSearching:
  /// the images before the one that was sought were not decoded at `until`; the next call goes on.
  Result read(PicturePool& pool, Image& image, std::string& problem,
              Clock::time_point until = Clock::time_point::max());

 private:
  struct Libraries;
  std::unique_ptr<Libraries> av_;
};

}  // namespace sslv
