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

/// An image with bytes of its own.
struct StillPicture {
  StillPicture(const ImageView& image, std::uint32_t frame, double t_capture);

  std::vector<std::uint8_t> bytes;
  ImageView view;
  std::uint32_t frame_number;
  double t_capture_s;
};

/// Images that somebody wants to look at for a while: the newest few of each camera, until nobody has asked
/// for them for long. May be used from any thread.
class Stills {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMaxOfACamera = 4;
  static constexpr std::chrono::minutes kLongest{10};

  /// Its number; numbers only grow.
  int keep(int camera_id, StillPicture picture, Clock::time_point now = Clock::now());
  /// Null when there is none of that number, or none any more.
  std::shared_ptr<const StillPicture> find(int camera_id, int number, Clock::time_point now = Clock::now());
  /// Lets go of what nobody has asked for.
  void forget_old(Clock::time_point now = Clock::now());

 private:
  struct Still {
    int number;
    Clock::time_point asked;
    std::shared_ptr<const StillPicture> picture;
  };
  void forget_old_locked(Clock::time_point now);

  std::mutex mutex_;  // guards what follows
  int newest_ = 0;
  std::map<int, std::deque<Still>> stills_;  // by camera, oldest first
};

}  // namespace sslv
