// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/source.h"
#include "services/cameras/fresh_frames.h"
#include "support/latest.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sslv {

/// Cameras 0 and 1, whose frames are delivered by the test, 10 ms apart, each grey and with a robot.
class FakeCameras {
 public:
  static constexpr int kWidth = 64, kHeight = 48;

  void deliver(int camera_id, int width = kWidth, PixelFormat format = PixelFormat::kRgb24) {
    const auto camera = static_cast<std::size_t>(camera_id);
    t_capture_s_[camera] += 0.01;
    cameras_[camera].put({{bytes_.data(), width, kHeight, 3 * width, format}, t_capture_s_[camera]});
  }
  void remove(int camera_id) { gone_ = camera_id; }
  WaitFrame wait_frame() {
    return [this](int camera_id, std::uint64_t newer_than,
                  std::chrono::milliseconds timeout) -> std::optional<LentFrame> {
      if (camera_id == gone_) throw CaptureError("no such camera");
      const auto newest = cameras_.at(static_cast<std::size_t>(camera_id)).wait_newer(newer_than, timeout);
      if (!newest) return std::nullopt;
      return LentFrame{newest->version, nullptr, newest->value.image, newest->value.t_capture_s, robots_};
    };
  }

 private:
  struct Delivered {
    ImageView image;
    double t_capture_s;
  };
  std::vector<std::uint8_t> bytes_ = std::vector<std::uint8_t>(std::size_t{3} * kWidth * kHeight, 100);
  std::vector<Robot> robots_{{Team::kBlue, 3, 0, 0, 0, 140, 30, 20, 1}};
  std::array<double, 2> t_capture_s_{100, 100};
  std::array<Latest<Delivered>, 2> cameras_;
  std::atomic<int> gone_ = -1;
};

}  // namespace sslv
