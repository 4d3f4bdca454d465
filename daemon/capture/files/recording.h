// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace sslv {

/// What is played instead of a camera: a folder of images, a video, a clip. One thread uses it.
class Recording {
 public:
  virtual ~Recording() = default;

  using Clock = std::chrono::steady_clock;

  /// Fills in all but t_capture_s. kImage; kIncomplete where the image is damaged, saying why in `problem`
  /// with the file's name; kEnd behind the last image; kTimeout when it was still searched for at `until`:
  /// the next call goes on. Throws std::exception when nothing more can be read.
  virtual CaptureStatus take(std::int64_t place, CapturedImage& image, std::string& problem,
                             Clock::time_point until) = 0;

  /// Images, as far as is known; after kEnd all are.
  virtual std::int64_t count() const = 0;
  /// 0: it does not say.
  virtual double frame_rate_hz() const { return 0; }
  /// From each image to the next, in s, where they are not evenly far apart; then there are count() of them,
  /// the last one until it begins again. Empty: they are.
  virtual std::vector<double> distances_s() const { return {}; }
};

}  // namespace sslv
