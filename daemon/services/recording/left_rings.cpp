// SPDX-License-Identifier: Apache-2.0
#include "services/recording/left_rings.h"

#include "base/log.h"
#include "clips/clip_reader.h"

#include <algorithm>
#include <utility>

namespace sslv {

LeftRings::LeftRings(std::vector<KeptFile> files) {
  for (KeptFile& kept : files) {
    names_.push_back(kept.name);
    try {
      auto ring = std::make_unique<LeftRing>(std::move(kept.file));
      const LeftRing::Extent& one = ring->extent();
      if (one.frames == 0) continue;
      extent_.oldest_ns = extent_.frames == 0 ? one.oldest_ns : std::min(extent_.oldest_ns, one.oldest_ns);
      extent_.newest_ns = std::max(extent_.newest_ns, one.newest_ns);
      extent_.frames += one.frames;
      extent_.bytes += one.bytes;
      cameras_.push_back({.ring = std::move(ring)});
    } catch (const ClipError& error) {
      log::info("memory of the run before, {}, is not used: {}", kept.name, error.what());
    }
  }
}

LeftRings::~LeftRings() {
  cameras_.clear();
  for (const std::string& name : names_) forget_file(name);
}

bool LeftRings::write_next(ClipWriter& writer, int every_nth) {
  Camera* first = nullptr;
  const ClipFrame* frame = nullptr;
  for (Camera& one : cameras_) {
    const ClipFrame* const oldest = one.ring->oldest();
    if (oldest == nullptr ||
        (frame != nullptr && oldest->info.times.arrived_ns >= frame->info.times.arrived_ns))
      continue;
    first = &one;
    frame = oldest;
  }
  if (first == nullptr) return false;
  if (!first->camera) {
    first->camera = std::make_unique<ClipCamera>(
        static_cast<int>(frame->info.camera_id), every_nth,
        [ring = first->ring.get()](std::uint32_t number) { return ring->setup(number); });
  }
  if (first->camera->write(writer, *frame)) {
    ++frames_;
    newest_s_ = std::max(newest_s_, frame->info.times.t_capture_s);
  }
  first->ring->drop_oldest();
  return true;
}

std::uint64_t LeftRings::missing() const {
  std::uint64_t out = 0;
  for (const Camera& one : cameras_) out += one.camera ? one.camera->missing() : 0;
  return out;
}

}  // namespace sslv
