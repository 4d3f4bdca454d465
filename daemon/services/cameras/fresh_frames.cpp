// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/fresh_frames.h"

#include "capture/source.h"

#include <fmt/format.h>

namespace sslv {

FreshFrames::FreshFrames(const WaitFrame& wait_frame, int camera_id, std::chrono::milliseconds silence)
    : wait_frame_(wait_frame), camera_id_(camera_id), silence_(silence) {
  if (const auto newest = wait_frame_(camera_id, 0, std::chrono::milliseconds(0))) version_ = newest->version;
}

std::optional<LentFrame> FreshFrames::next(std::chrono::milliseconds timeout) {
  auto frame = wait_frame_(camera_id_, version_, timeout);
  const auto now = Clock::now();
  if (frame) {
    version_ = frame->version;
    heard_ = now;
  } else if (now - heard_ >= silence_) {
    throw CaptureError(fmt::format("no image for {:g} s; is the camera running?",
                                   std::chrono::duration<double>(silence_).count()));
  }
  return frame;
}

void add_frame(MeanPicture& mean, const LentFrame& frame) {
  mean.whole = frame.whole;
  if (mean.add(frame.image)) return;
  throw CaptureError(mean.frames() == 0 ? fmt::format("the camera's images have no colours ({})",
                                                      name_of(frame.image.format))
                                        : "the camera's images have changed in the meantime; start again");
}

}  // namespace sslv
