// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/files/picture_pool.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace sslv {

/// Reads the images of one image or video file, decoded to rgb24 by FFmpeg's libraries. Without FFmpeg
/// (file_media_jpeg.cpp) it reads only JPEGs.
class MediaReader {
 public:
  enum class Result { kPicture, kDamaged, kEnd, kSearching };
  using Clock = std::chrono::steady_clock;

  /// Throws std::runtime_error with the reason, without the path. A `still` image must be valid to its last
  /// byte; in a video decoders may tolerate missing parts of the stream.
  MediaReader(const std::string& path, bool still);
  ~MediaReader();

  /// The file's frame rate; 0 if unknown.
  double frame_rate_hz() const;

  /// The number of images that the file reports, or an estimate from its duration; 0 if unknown.
  std::int64_t count() const;
  /// Makes image `picture`, counted from 0, the next one to read. The first call reads the whole file. False
  /// if the seek was not complete at `until`: the next call continues, and no image can be read until the
  /// seek is complete. Throws std::runtime_error.
  bool seek(std::int64_t picture, Clock::time_point until);
  /// Time of the last image on the file's clock.
  std::optional<double> time_s() const;

  /// Reads the next image. kDamaged: `problem` has the reason, and the next call continues after the damage.
  /// kSearching, after a seek: not all images before the wanted image were decoded by `until`; the next call
  /// continues.
  Result read(PicturePool& pool, Image& image, std::string& problem,
              Clock::time_point until = Clock::time_point::max());

 private:
  struct Libraries;
  std::unique_ptr<Libraries> av_;
};

}  // namespace sslv
