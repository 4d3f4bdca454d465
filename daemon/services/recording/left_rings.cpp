// SPDX-License-Identifier: Apache-2.0
#include "services/recording/left_rings.h"

#include "base/log.h"
#include "clips/clip_reader.h"
#include "services/recording/last_seconds.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

namespace sslv {
namespace {

/// What such a name says; not what the frames do, which may be damaged.
std::optional<int> camera_in(std::string_view name) {
  name.remove_prefix(std::min(name.size(), std::string_view(LastSeconds::kKeptName).size()));
  int id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  return error == std::errc() && end != name.data() + name.size() && *end == '-' && id >= 0
             ? std::optional(id)
             : std::nullopt;
}

}  // namespace

LeftRings::LeftRings(std::vector<KeptFile> files) {
  for (KeptFile& kept : files) {
    names_.push_back(kept.name);
    const auto id = camera_in(kept.name);
    if (!id) continue;
    try {
      auto ring = std::make_unique<LeftRing>(std::move(kept.file));
      const LeftRing::Extent& one = ring->extent();
      if (one.frames == 0) continue;
      extent_.oldest_ns = extent_.frames == 0 ? one.oldest_ns : std::min(extent_.oldest_ns, one.oldest_ns);
      extent_.newest_ns = std::max(extent_.newest_ns, one.newest_ns);
      extent_.frames += one.frames;
      extent_.bytes += one.bytes;
      cameras_.push_back({.id = *id, .ring = std::move(ring)});
    } catch (const RingWasRead&) {
      was_read_ = true;
    } catch (const ClipError& error) {
      log::info("memory of the run before, {}, is not used: {}", kept.name, error.what());
    }
  }
}

LeftRings::~LeftRings() {
  cameras_.clear();
  for (const std::string& name : names_) forget_file(name);
}

void LeftRings::put_back() noexcept {
  for (const Camera& one : cameras_) one.ring->put_back();
  names_.clear();
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
        first->id, every_nth,
        [ring = first->ring.get()](std::uint32_t number) { return ring->setup(number); });
  }
  if (first->ring->lacks_one()) first->camera->lack_one();
  ClipFrame of_camera = *frame;
  of_camera.info.camera_id = static_cast<std::uint32_t>(first->id);
  if (first->camera->write(writer, of_camera)) {
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
