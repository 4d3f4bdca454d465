// SPDX-License-Identifier: Apache-2.0
#include "services/recording/last_seconds.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "health/memory_left.h"
#include "services/recording/recording_files.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// How long what cameras send is measured before it counts.
constexpr double kMeasured_s = 2;
/// A part may differ by so much of what it should be: to change it costs the images in it.
constexpr double kMayDiffer = 0.3;
/// Of the memory that is left: the rest is for the rest of the service and of the computer.
constexpr double kOfWhatIsLeft = 0.5;

bool same(const LastSecondsSettings& a, const LastSecondsSettings& b) {
  return params_to_json(a) == params_to_json(b);
}

}  // namespace

void LastSeconds::measure(double now_s) {
  const auto recorded = cameras_.recorded();
  const std::lock_guard lock(mutex_);
  const bool is_same = std::ranges::equal(known_, recorded, [](const auto& known, const auto& camera) {
    return known.first == camera.first && known.second.camera == camera.second;
  });
  if (!is_same) {
    changed_s_ = now_s;
    std::map<int, Known> now;
    for (const auto& [id, camera] : recorded) {
      Known& one = now[id];
      if (const auto before = known_.find(id); before != known_.end() && before->second.camera == camera)
        one = std::move(before->second);
      one.camera = camera;
      one.seen_s = now_s;
      one.seen = camera->seen();
    }
    known_ = std::move(now);
  }
  for (auto& [id, known] : known_) {
    const double passed_s = now_s - known.seen_s;
    if (passed_s < kMeasured_s) continue;
    const RecordedCamera::Seen seen = known.camera->seen();
    // One that has stopped keeps its part: its last seconds tell why.
    if (seen.frames != known.seen.frames)
      known.bytes_per_s = static_cast<double>(seen.bytes - known.seen.bytes) / passed_s;
    known.seen = seen;
    known.seen_s = now_s;
  }
}

void LastSeconds::look(const LastSecondsSettings& settings) {
  const double now_s = steady_s();
  measure(now_s);
  if (now_s - changed_s_ < kMeasured_s) return;
  std::uint64_t ours = 0;
  bool changes = false;
  {
    const std::lock_guard lock(mutex_);
    changes = !same(settings_, settings);
    settings_ = settings;
    for (const auto& [id, known] : known_) ours += known.ring ? known.ring->bytes() : 0;
  }
  const std::uint64_t wanted = static_cast<std::uint64_t>(settings.memory_mb) * kMb;
  std::string problem;
  const auto may =
      static_cast<std::uint64_t>(kOfWhatIsLeft * static_cast<double>(ours + memory_left_bytes()));
  if (wanted > may) {
    problem = fmt::format(
        "only {} MB of memory can be taken for them of the {} MB that /recording/last_seconds/memory_mb "
        "wants",
        may / kMb, settings.memory_mb);
  }
  try {
    share_out(std::min(wanted, may));
  } catch (const std::system_error& error) {
    problem = error.what();
  }
  if (!problem.empty() && problem_.empty()) log::warning("the cameras' last seconds: {}", problem);
  const std::lock_guard lock(mutex_);
  for (const auto& [id, known] : known_) {
    if (changes) hand_over(known);
    const ImageRing::Extent extent = known.ring ? known.ring->extent() : ImageRing::Extent{};
    if (extent.frames > 0 || !known.ring)
      known.camera->forget_before(known.ring ? extent.oldest_setup
                                             : std::numeric_limits<std::uint32_t>::max());
  }
  problem_ = std::move(problem);
}

void LastSeconds::share_out(std::uint64_t bytes) {
  double all_per_s = 0;
  for (const auto& [id, known] : known_) all_per_s += known.bytes_per_s;
  if (all_per_s <= 0 && bytes > 0) return;
  const auto part_of = [&](const Known& known) {
    return static_cast<std::size_t>(static_cast<double>(bytes) * known.bytes_per_s /
                                    std::max(all_per_s, 1.0));
  };
  const auto is_good = [&](const Known& known) {
    const auto part = static_cast<double>(part_of(known));
    const double now = known.ring ? static_cast<double>(known.ring->bytes()) : 0;
    return std::abs(now - part) <= kMayDiffer * part;
  };
  if (std::ranges::all_of(known_, [&](const auto& one) { return is_good(one.second); })) return;
  const std::lock_guard lock(mutex_);
  // First all is given back that is to be of another size, so that never more than `bytes` are taken.
  for (auto& [id, known] : known_) {
    if (is_good(known) || !known.ring) continue;
    known.ring.reset();
    hand_over(known);
  }
  for (auto& [id, known] : known_) {
    if (known.ring || part_of(known) == 0) continue;
    known.ring = std::make_shared<ImageRing>(part_of(known));
    hand_over(known);
  }
}

void LastSeconds::hand_over(const Known& known) const {
  RecordedFrames frames{.ring = known.ring, .every_nth = settings_.every_nth};
  switch (settings_.images) {
    case LastSecondsSettings::Images::kWhole: frames.images = RecordedFrames::Images::kWhole; break;
    case LastSecondsSettings::Images::kEveryNth: frames.images = RecordedFrames::Images::kEveryNth; break;
    case LastSecondsSettings::Images::kFound: frames.images = RecordedFrames::Images::kFound; break;
  }
  known.camera->keep(std::move(frames));
}

std::vector<LastSeconds::Ring> LastSeconds::rings() const {
  std::vector<Ring> out;
  const std::lock_guard lock(mutex_);
  for (const auto& [id, known] : known_) {
    if (known.ring) out.push_back({id, known.camera, known.ring, known.bytes_per_s});
  }
  return out;
}

LastSeconds::Status LastSeconds::status() const {
  Status out;
  const std::lock_guard lock(mutex_);
  out.settings = settings_;
  out.wanted_bytes = static_cast<std::uint64_t>(settings_.memory_mb) * kMb;
  out.problem = problem_;
  for (const auto& [id, known] : known_) {
    CameraStatus one{.id = id};
    if (known.ring) {
      const ImageRing::Extent extent = known.ring->extent();
      one.frames = extent.frames;
      one.dropped = extent.dropped;
      one.bytes = known.ring->bytes();
      one.seconds = static_cast<double>(extent.newest_ns - extent.oldest_ns) * 1e-9;
      out.bytes += one.bytes;
    }
    out.cameras.push_back(one);
  }
  return out;
}

}  // namespace sslv
