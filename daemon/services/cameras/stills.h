// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace sslv {

/// An image that owns its bytes.
struct StillPicture {
  StillPicture(const ImageView& image, std::uint32_t frame, double t_capture);

  std::vector<std::uint8_t> bytes;
  ImageView view;
  std::uint32_t frame_number;
  double t_capture_s;
};

/// Still images for viewing: the newest kMaxOfACamera of each camera. A still is dropped when nobody has
/// requested it for kLongest. Thread-safe.
class Stills {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMaxOfACamera = 4;
  static constexpr std::chrono::minutes kLongest{10};

  /// Returns the still's number; numbers increase over all cameras.
  int keep(int camera_id, StillPicture picture, Clock::time_point now = Clock::now());
  /// Returns null if there never was a still with this number, or if it was dropped.
  std::shared_ptr<const StillPicture> find(int camera_id, int number, Clock::time_point now = Clock::now());
  /// Drops stills that nobody has requested for kLongest.
  void forget_old(Clock::time_point now = Clock::now());

 private:
  struct Still {
    int number;
    Clock::time_point asked;
    std::shared_ptr<const StillPicture> picture;
  };
  void forget_old_locked(Clock::time_point now);

  std::mutex mutex_;  // guards the members below
  int newest_ = 0;
  std::map<int, std::deque<Still>> stills_;  // by camera, oldest first
};

}  // namespace sslv
