// SPDX-License-Identifier: Apache-2.0
#include "capture/files/file_clip.h"

#include "capture/files/picture_pool.h"
#include "clips/clip_reader.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sslv {
namespace {

class ClipRecording final : public Recording {
 public:
  ClipRecording(const std::string& path, std::optional<std::uint32_t> camera_id)
      : reader_(path), name_(std::filesystem::path(path).stem().string()) {
    std::vector<std::uint32_t> ids;
    for (const ClipReader::Camera& camera : reader_.cameras()) {
      if (camera.frames.empty()) continue;
      ids.push_back(camera.id);
      if (frames_.empty() && camera.id == camera_id.value_or(camera.id)) frames_ = camera.frames;
    }
    if (ids.empty()) throw std::runtime_error(fmt::format("{}: no frames in this clip", path));
    constexpr std::size_t kMaxNamed = 20;
    if (frames_.empty())
      throw std::runtime_error(fmt::format(
          "{}: no camera {} in this clip; expected {}{}", path, *camera_id,
          fmt::join(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(std::min(ids.size(), kMaxNamed)),
                    ", "),
          ids.size() > kMaxNamed ? "..." : ""));
  }

  CaptureStatus take(std::int64_t place, CapturedImage& image, std::string& problem,
                     Clock::time_point /*until*/) override {
    if (place >= count()) return CaptureStatus::kEnd;
    try {
      const ClipFrame& frame =
          reader_.read(frames_[static_cast<std::size_t>(place)], [&](std::size_t bytes) -> std::uint8_t* {
            std::uint8_t* pixels = nullptr;
            image.image = pool_.take(bytes, pixels);
            return pixels;
          });
      if (frame.image.empty()) {
        problem = fmt::format("{}: frame {} has no image", name_, frame.info.number);
        return CaptureStatus::kIncomplete;
      }
      image.image.narrow_to(frame.image);
      const CaptureTimes& times = frame.info.times;
      image.times.t_capture_camera_s = times.t_capture_camera_s.value_or(times.t_capture_s);
      image.whole = frame.info.whole;
      image.name = fmt::format("{}{:06}", name_, frame.info.number);
      return CaptureStatus::kImage;
    } catch (const ClipError& error) {
      image.image = Image();
      problem = error.what();
      return CaptureStatus::kIncomplete;
    }
  }

  std::int64_t count() const override { return static_cast<std::int64_t>(frames_.size()); }

  std::vector<double> distances_s() const override {
    std::vector<double> out;
    const auto time_s = [&](std::size_t i) { return reader_.entries()[frames_[i]].t_capture_s; };
    for (std::size_t i = 1; i < frames_.size(); ++i) out.push_back(time_s(i) - time_s(i - 1));
    // The last image is shown for the median time between images.
    std::vector<double> sorted = out;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    out.push_back(sorted.empty() ? 1 : *middle);
    return out;
  }

 private:
  ClipReader reader_;
  const std::string name_;
  std::vector<std::uint32_t> frames_;  // indices of this camera's frames in the clip
  PicturePool pool_;
};

}  // namespace

std::unique_ptr<Recording> open_clip(const std::string& path, std::optional<std::uint32_t> camera_id) {
  return std::make_unique<ClipRecording>(path, camera_id);
}

}  // namespace sslv
