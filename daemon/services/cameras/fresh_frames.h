// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/line_picture.h"
#include "image/image.h"
#include "vision/detections.h"

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>

namespace sslv {

/// A camera's finished frame, on loan: let go soon.
struct LentFrame {
  std::uint64_t version = 0;
  std::shared_ptr<const void> hold;
  ImageView image;
  double t_capture_s = 0;
  std::span<const Robot> robots{};
  WholePicture whole{};
  std::uint32_t number = 0;
  std::span<const Ball> balls{};
  std::span<const Robot> second_robots{};  // see RobotList
};

/// The newest frame once its version is newer than the given one (0: any); nothing after the timeout. Throws
/// CaptureError when there is no such camera: nobody must ask for it again and again without a pause.
using WaitFrame = std::function<std::optional<LentFrame>(int camera_id, std::uint64_t newer_than,
                                                         std::chrono::milliseconds timeout)>;

/// A camera that delivers nothing for so long fails.
inline constexpr std::chrono::milliseconds kSilence = std::chrono::seconds(10);

/// A camera's frames from now on: the newest one of a camera that is lost may be old.
class FreshFrames {
 public:
  FreshFrames(const WaitFrame& wait_frame, int camera_id, std::chrono::milliseconds silence);

  /// The next frame; nothing after the timeout. Throws CaptureError when none came for too long, or when
  /// the camera is gone.
  std::optional<LentFrame> next(std::chrono::milliseconds timeout);

 private:
  using Clock = std::chrono::steady_clock;

  const WaitFrame& wait_frame_;
  int camera_id_;
  std::chrono::milliseconds silence_;
  std::uint64_t version_ = 0;
  Clock::time_point heard_ = Clock::now();
};

/// Adds a camera's frame to the mean. Throws CaptureError when it has no colours or another size.
void add_frame(MeanPicture& mean, const LentFrame& frame);

}  // namespace sslv
