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

/// A camera's finished frame, on loan: release it soon.
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

/// Returns the newest frame once its version is newer than `newer_than` (0: any); nothing on timeout. Throws
/// CaptureError if there is no such camera, because callers would otherwise poll without a pause.
using WaitFrame = std::function<std::optional<LentFrame>(int camera_id, std::uint64_t newer_than,
                                                         std::chrono::milliseconds timeout)>;

/// A camera that delivers nothing for this time counts as failed.
inline constexpr std::chrono::milliseconds kSilence = std::chrono::seconds(10);

/// The frames that a camera delivers after construction. Skips the frame that is the newest at construction:
/// it may be old if the camera is lost.
class FreshFrames {
 public:
  FreshFrames(const WaitFrame& wait_frame, int camera_id, std::chrono::milliseconds silence);

  /// Returns the next frame; nothing on timeout. Throws CaptureError if no frame arrived for `silence`, or if
  /// the camera was removed.
  std::optional<LentFrame> next(std::chrono::milliseconds timeout);

 private:
  using Clock = std::chrono::steady_clock;

  const WaitFrame& wait_frame_;
  int camera_id_;
  std::chrono::milliseconds silence_;
  std::uint64_t version_ = 0;
  Clock::time_point heard_ = Clock::now();
};

/// Adds a camera's frame to the mean. Throws CaptureError if it has no colours or another size.
void add_frame(MeanPicture& mean, const LentFrame& frame);

}  // namespace sslv
