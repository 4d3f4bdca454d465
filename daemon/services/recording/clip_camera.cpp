// SPDX-License-Identifier: Apache-2.0
#include "services/recording/clip_camera.h"

#include "clips/clip_format.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace sslv {

ClipCamera::ClipCamera(LastSeconds::Ring ring, int every_nth)
    : from_(std::move(ring)),
      every_nth_(static_cast<std::uint32_t>(every_nth)),
      dropped_before_(from_.ring->extent().dropped) {}

double ClipCamera::expected_bytes(double seconds) const {
  return static_cast<double>(from_.ring->held_bytes()) + from_.bytes_per_s * std::max(0.0, seconds);
}

bool ClipCamera::write_oldest(ClipWriter& writer) {
  const ClipFrame* const held = from_.ring->oldest_held();
  if (held == nullptr) return false;
  ClipFrame frame = *held;
  // Begin with a keyframe, which has the saved state of the stages, so that a replay starts in the live
  // state.
  bool is_good = has_begun() || !frame.memory.empty();
  auto setup = setups_.find(frame.setup);
  if (is_good && setup == setups_.end()) {
    const std::vector<std::byte> payload = from_.ring->setup(frame.setup);
    const auto parts = setup_in(payload);
    is_good = parts.has_value();
    if (is_good) {
      const auto id = static_cast<std::uint32_t>(from_.camera_id);
      setup = setups_.emplace(frame.setup, writer.add_setup(id, parts->json, parts->table)).first;
    }
  }
  if (is_good) {
    frame.info.camera_id = static_cast<std::uint32_t>(from_.camera_id);
    frame.setup = setup->second;
    writer.add(frame);
    // Frames that every_nth_ skips are not missing.
    const std::uint32_t step = frame.info.number - last_number_.value_or(frame.info.number - 1);
    if (step > every_nth_) note_missing(writer, (step - 1) / every_nth_);
    last_number_ = frame.info.number;
    newest_s_ = frame.info.times.t_capture_s;
  }
  from_.ring->let_go();
  return is_good;
}

void ClipCamera::end_now() {
  if (!dropped_at_end_) dropped_at_end_ = from_.ring->extent().dropped;
}

void ClipCamera::note_dropped(ClipWriter& writer) {
  end_now();
  const std::uint64_t dropped = *dropped_at_end_ - dropped_before_;
  note_missing(writer, dropped - std::min(dropped, missing_));
}

void ClipCamera::note_missing(ClipWriter& writer, std::uint64_t frames) {
  if (frames == 0) return;
  writer.note_missing(static_cast<std::uint32_t>(from_.camera_id), frames);
  missing_ += frames;
}

}  // namespace sslv
