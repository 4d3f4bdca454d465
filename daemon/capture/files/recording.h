// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace sslv {

/// A recording that replaces a camera: a folder of images, a video or a clip. Used by one thread.
class Recording {
 public:
  virtual ~Recording() = default;

  using Clock = std::chrono::steady_clock;

  /// Reads image `place`; sets everything except t_capture_s. Returns kImage; kIncomplete for a damaged
  /// image, with the file's name and the reason in `problem`; kEnd after the last image; kTimeout if the seek
  /// to the image was not complete at `until`: the next call continues. Throws std::exception if no more
  /// images can be read.
  virtual CaptureStatus take(std::int64_t place, CapturedImage& image, std::string& problem,
                             Clock::time_point until) = 0;

  /// Number of images, as far as known; exact after kEnd.
  virtual std::int64_t count() const = 0;
  /// 0: unknown.
  virtual double frame_rate_hz() const { return 0; }
  /// Times from each image to the next, in s: count() values; the last is the time until the recording begins
  /// again. Empty if all times are equal.
  virtual std::vector<double> distances_s() const { return {}; }
};

}  // namespace sslv
