// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ssl_vision_wrapper.pb.h"
#include "support/group_listener.h"
#include "support/patience.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <thread>

namespace sslv::test {

/// Watches one camera's packets in its own thread, starting on construction.
class FrameNumbers {
 public:
  FrameNumbers(std::uint16_t port, std::uint32_t camera)
      : listener_(port), thread_([this, camera] { listen(camera); }) {}
  ~FrameNumbers() { stop(); }
  FrameNumbers(const FrameNumbers&) = delete;
  FrameNumbers& operator=(const FrameNumbers&) = delete;

  void stop() {
    is_over_ = true;
    if (thread_.joinable()) thread_.join();
  }

  /// Waits for `frames` more frames.
  void wait_for(int frames) const {
    const int enough = frames_ + frames;
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (frames_ < enough) {
      if (std::chrono::steady_clock::now() > deadline)
        throw std::runtime_error("the other camera has stopped");
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  // Valid after stop().
  int frames() const { return frames_; }
  /// Skipped frame numbers, including those of datagrams that this listener lost, see overflows().
  int missing() const { return missing_; }
  std::uint32_t overflows() const { return listener_.overflows(); }
  /// The longest interval between two of its frames.
  double longest_gap_s() const { return longest_gap_s_; }

 private:
  void listen(std::uint32_t camera) {
    SSL_WrapperPacket packet;
    SSL_DetectionFrame last;
    while (!is_over_) {
      const auto bytes = listener_.receive(100);
      if (!bytes || !packet.ParseFromString(*bytes) || packet.detection().camera_id() != camera ||
          !packet.has_detection()) {
        continue;
      }
      const SSL_DetectionFrame& frame = packet.detection();
      if (frames_++ > 0) {
        missing_ += static_cast<int>(frame.frame_number() - last.frame_number()) - 1;
        longest_gap_s_ = std::max(longest_gap_s_, frame.t_capture() - last.t_capture());
      }
      last = frame;
    }
  }

  GroupListener listener_;
  std::atomic<bool> is_over_{false};
  std::atomic<int> frames_{0};
  int missing_ = 0;
  double longest_gap_s_ = 0;
  std::thread thread_;  // last member: uses the others
};

}  // namespace sslv::test
