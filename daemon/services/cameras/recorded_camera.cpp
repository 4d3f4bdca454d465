// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/recorded_camera.h"

#include "base/log.h"
#include "clips/clip_format.h"
#include "replay/clip_setup.h"

#include <algorithm>
#include <exception>
#include <span>
#include <utility>

namespace sslv {
namespace {

/// Interval of keyframes: frames that are recorded with the saved state of the stages. A clip can begin only
/// at a keyframe.
constexpr std::int64_t kKeyInterval_ns = 250'000'000;
/// Buffer size for the saved state of a stack's stages, which takes a few kB.
constexpr std::size_t kMemoryBytes = 256 * 1024;

}  // namespace

RecordedCamera::RecordedCamera(int id, const DetectionSender& sender, Clock now_ns)
    : id_(id), sender_(sender), now_ns_(std::move(now_ns)), memory_(kMemoryBytes) {}

RecordedCamera::Seen RecordedCamera::seen() const {
  return {frames_seen_.load(std::memory_order_relaxed), bytes_seen_.load(std::memory_order_relaxed)};
}

void RecordedCamera::frame_begins(const CameraSetup& setup) noexcept {
  memory_bytes_ = 0;
  const auto kept = frames_.use();
  if (!kept->ring) {
    ring_ = nullptr;
    return;
  }
  is_kept_ = count_++ % static_cast<std::uint64_t>(kept->every_nth) == 0;
  if (!is_kept_) return;
  const std::int64_t now_ns = now_ns_();
  if (ring_ == kept->ring.get() && pipeline_ == setup.pipeline.get() && now_ns < next_key_ns_) return;
  ring_ = kept->ring.get();
  pipeline_ = setup.pipeline.get();
  next_key_ns_ = now_ns + kKeyInterval_ns;
  memory_bytes_ = setup.pipeline->save(memory_);
}

void RecordedCamera::frame_ends(const Frame& frame, const CameraSetup& setup) noexcept {
  const ImageView& image = frame.image.view();
  frames_seen_.fetch_add(1, std::memory_order_relaxed);
  bytes_seen_.fetch_add(clip_image_bytes(image), std::memory_order_relaxed);
  const auto kept = frames_.use();
  // A new ring is used from the next frame on.
  if (!kept->ring || kept->ring.get() != ring_ || !is_kept_) return;
  ring_->put({.info = frame.info,
              .setup = setup.number,
              .image = image,
              .packet = sender_.packet_of(frame.info.number),
              .memory = std::span(memory_).first(memory_bytes_)});
}

void RecordedCamera::keep(RecordedFrames frames) {
  std::shared_ptr<ImageRing> before;  // freed after the lock is released
  {
    const std::lock_guard lock(mutex_);
    if (frames.ring != ring_of_setups_) {
      before = std::exchange(ring_of_setups_, frames.ring);
      for (const Setup& setup : setups_) put_into_ring(setup);
    }
  }
  frames_.store(std::move(frames));
}

void RecordedCamera::note(CameraSetup& setup, std::shared_ptr<const Config> config) {
  const std::lock_guard lock(mutex_);
  setup.number = next_number_++;
  if (!config && !setups_.empty()) config = setups_.back().config;
  setups_.push_back({std::make_shared<const CameraSetup>(setup), std::move(config)});
  put_into_ring(setups_.back());
}

/// Called as soon as a setup exists: after a crash, no setup could be added for a clip.
void RecordedCamera::put_into_ring(const Setup& setup) {
  if (!ring_of_setups_ || !setup.config) return;
  const auto& cameras = setup.config->cameras;
  const auto camera = std::ranges::find(cameras, id_, &CameraSettings::id);
  if (camera == cameras.end()) return;
  try {
    ring_of_setups_->put_setup(
        setup.setup->number,
        clip_setup(*setup.config, static_cast<std::size_t>(camera - cameras.begin()), *setup.setup));
  } catch (const std::exception& error) {
    log::warning("camera {}: a clip would lack its settings: {}", id_, error.what());
  }
}

void RecordedCamera::forget_before(std::uint32_t number) {
  std::vector<Setup> gone;  // tables are freed after the lock is released
  const std::lock_guard lock(mutex_);
  const auto first = std::ranges::find_if(setups_, [&](const Setup& one) {
    return one.setup->number >= number || one.setup->number + 1 == next_number_;
  });
  gone.assign(std::make_move_iterator(setups_.begin()), std::make_move_iterator(first));
  setups_.erase(setups_.begin(), first);
  if (ring_of_setups_ && !setups_.empty())
    ring_of_setups_->forget_setups_before(setups_.front().setup->number);
}

}  // namespace sslv
