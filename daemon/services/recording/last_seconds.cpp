// SPDX-License-Identifier: Apache-2.0
#include "services/recording/last_seconds.h"

#include "base/log.h"
#include "base/params_json.h"
#include "health/memory_left.h"
#include "services/recording/recording_files.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Minimum interval for measuring a data rate, and delay after a change of the cameras.
constexpr double kMeasured_s = 0.9;
/// Number of intervals without a steady rate after which the current rate is accepted anyway.
constexpr int kUnevenAtMost = 5;
/// Relative difference up to which rates count as equal and rings keep their size, because resizing a ring
/// loses its images.
constexpr double kMayDiffer = 0.3;
/// Memory for a clip, relative to the measured data rates, which vary.
constexpr double kMoreThanMeasured = 1.1;
/// Clips that fit into the quota of recordings, if the settings give no size of the memory.
constexpr std::uint64_t kClipsInQuota = 4;
/// Usable fraction of the available memory; the rest is for the service and the computer.
constexpr double kOfWhatIsLeft = 0.5;

/// Makes the service manager release the ring's memory when the ring is destroyed, unless put_back() was
/// called. After a crash, the service manager still has the memory.
std::shared_ptr<ImageRing> kept_as(const std::string& name, std::unique_ptr<ImageRing> ring) {
  return {ring.release(), [name](ImageRing* ending) {
            if (!ending->is_put_back()) forget_file(name);
            delete ending;
          }};
}

std::shared_ptr<ImageRing> kept_ring(int camera_id, std::size_t bytes, const std::stop_token& stop) {
  static std::atomic<unsigned> count{0};
  const std::string name = fmt::format("{}{}-{}", LastSeconds::kKeptName, camera_id, ++count);
  auto ring = kept_as(name, std::make_unique<ImageRing>(bytes, stop));
  keep_file(name, ring->fd());
  return ring;
}

/// The camera id in a name that kept_ring() made. The ids in frames are not used, because they may be
/// damaged.
std::optional<int> camera_in(std::string_view name) {
  if (!name.starts_with(LastSeconds::kKeptName)) return std::nullopt;
  name.remove_prefix(std::string_view(LastSeconds::kKeptName).size());
  int id = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), id);
  const bool is_name = error == std::errc() && end != name.data() + name.size() && *end == '-' && id >= 0;
  return is_name ? std::optional(id) : std::nullopt;
}

bool same(const LastSecondsSettings& a, const LastSecondsSettings& b) {
  return params_to_json(a) == params_to_json(b);
}

}  // namespace

/// Updates the list of cameras and their data rates.
void LastSeconds::measure(std::map<int, Known>& known, double now_s) {
  const auto recorded = cameras_.recorded();
  const bool is_same = std::ranges::equal(known, recorded, [](const auto& one, const auto& camera) {
    return one.first == camera.first && one.second.camera == camera.second;
  });
  if (!is_same) {
    changed_s_ = now_s;
    std::map<int, Known> now;
    for (const auto& [id, camera] : recorded) {
      const auto before = known.find(id);
      if (before != known.end() && before->second.camera == camera) {
        now.emplace(id, before->second);
      } else {
        now.emplace(id, Known{.seen = camera->seen(), .seen_s = now_s, .camera = camera});
      }
    }
    known = std::move(now);
  }
  for (auto& [id, one] : known) {
    one.camera->tidy();
    const double passed_s = now_s - one.seen_s;
    if (passed_s < kMeasured_s) continue;
    const RecordedCamera::Seen seen = one.camera->seen();
    // A camera that stopped or became slow keeps its memory, because its last seconds show why. Only a higher
    // rate or another size of images counts, and only if two successive intervals agree, which excludes
    // intervals in which the camera started or stopped. A camera without a steady rate receives memory after
    // kUnevenAtMost intervals.
    if (seen.frames != one.seen.frames) {
      one.image_bytes = (seen.bytes - one.seen.bytes) / (seen.frames - one.seen.frames);
      const double rate = static_cast<double>(seen.bytes - one.seen.bytes) / passed_s;
      const bool is_even = std::abs(rate - one.last_bytes_per_s) <= kMayDiffer * rate;
      if (is_even || (one.bytes_per_s <= 0 && ++one.uneven > kUnevenAtMost)) {
        const auto image_bytes = static_cast<double>(one.image_bytes);
        const bool is_other_size =
            std::abs(image_bytes - static_cast<double>(one.rated_bytes)) > kMayDiffer * image_bytes;
        if (is_other_size || rate > one.bytes_per_s) {
          one.bytes_per_s = rate;
          one.rated_bytes = one.image_bytes;
        }
      }
      one.last_bytes_per_s = rate;
    }
    one.seen = seen;
    one.seen_s = now_s;
  }
}

void LastSeconds::publish(const std::map<int, Known>& known) {
  std::map<int, Known> before = known;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  known_.swap(before);
}

void LastSeconds::look(const RecordingSettings& recording, double now_s, const std::stop_token& stop) {
  const LastSecondsSettings& settings = recording.last_seconds;
  std::map<int, Known> known = known_;  // no lock: only this thread changes known_
  measure(known, now_s);
  publish(known);
  if (now_s - changed_s_ < kMeasured_s) return;
  const bool changes = !same(settings_, settings);
  std::uint64_t ours = 0;
  double all_per_s = 0;
  for (const auto& [id, one] : known) {
    ours += one.ring ? one.ring->bytes() : 0;
    if (one.is_kept()) all_per_s += one.bytes_per_s / settings.kept_every();
  }
  const double clip_s = recording.clips.seconds + recording.clips.seconds_after;
  const std::uint64_t wanted = settings.memory_mb
                                   ? static_cast<std::uint64_t>(*settings.memory_mb) * kMb
                                   : static_cast<std::uint64_t>(kMoreThanMeasured * all_per_s * clip_s);
  auto may = static_cast<std::uint64_t>(
      kOfWhatIsLeft * (static_cast<double>(ours) + static_cast<double>(memory_left_bytes())));
  std::string problem;
  if (settings.memory_mb && wanted > may) {
    problem = fmt::format(
        "only {} MB of memory are available for them, not the {} MB of /recording/last_seconds/memory_mb",
        may / kMb, *settings.memory_mb);
  }
  if (!settings.memory_mb) {
    // A clip must fit into its share of the disk.
    may = std::min(may, static_cast<std::uint64_t>(recording.quota_mb) * kMb / kClipsInQuota);
    // Memory that other programs free is used only if it is much, because resizing loses images.
    if (ours > 0 && ours <= may && may < 2 * ours && wanted > may) may = ours;
  }
  {
    const std::lock_guard lock(mutex_);
    settings_ = settings;
    wanted_bytes_ = settings.memory_mb || wanted > may ? wanted : 0;
  }
  try {
    share_out(known, std::min(wanted, may), stop);
  } catch (const std::system_error& error) {
    if (stop.stop_requested()) return;
    problem = error.what();
  }
  publish(known);
  for (const auto& [id, one] : known) {
    if (changes) hand_over(one);
    const ImageRing::Extent extent = one.ring ? one.ring->extent() : ImageRing::Extent{};
    if (extent.frames > 0 || !one.ring)
      one.camera->forget_before(one.ring ? extent.oldest_setup : std::numeric_limits<std::uint32_t>::max());
  }
  for (const auto& [id, one] : known) {
    if (settings.memory_mb != 0 && problem.empty() && !one.is_kept())
      problem = fmt::format("the images of camera {} are larger than {} MiB, the most that a clip can hold",
                            id, kMaxClipImageBytes >> 20U);
  }
  if (!problem.empty() && problem_.empty()) log::warning("the cameras' last seconds: {}", problem);
  const std::lock_guard lock(mutex_);
  problem_ = std::move(problem);
}

void LastSeconds::share_out(std::map<int, Known>& known, std::uint64_t bytes, const std::stop_token& stop) {
  double all_per_s = 0;
  const auto per_s = [](const Known& one) { return one.is_kept() ? one.bytes_per_s : 0; };
  for (const auto& [id, one] : known) all_per_s += per_s(one);
  const bool are_kept = std::ranges::all_of(known, [](const auto& one) { return one.second.is_kept(); });
  if (all_per_s <= 0 && bytes > 0 && are_kept) return;
  const auto part_of = [&](const Known& one) {
    return static_cast<std::size_t>(static_cast<double>(bytes) * per_s(one) / std::max(all_per_s, 1.0));
  };
  const auto is_good = [&](const Known& one) {
    const auto part = static_cast<double>(part_of(one));
    const double now = one.ring ? static_cast<double>(one.ring->bytes()) : 0;
    return std::abs(now - part) <= kMayDiffer * part;
  };
  if (std::ranges::all_of(known, [&](const auto& one) { return is_good(one.second); })) return;
  // First free all rings of the wrong size, so that never more than `bytes` are allocated.
  for (auto& [id, one] : known) {
    if (is_good(one) || !one.ring) continue;
    one.ring.reset();
    hand_over(one);
  }
  publish(known);
  for (auto& [id, one] : known) {
    one.camera->tidy();
    if (one.ring || part_of(one) == 0) continue;
    one.ring = kept_ring(id, part_of(one), stop);
    hand_over(one);
  }
}

void LastSeconds::hand_over(const Known& known) const {
  known.camera->keep({.ring = known.ring, .every_nth = settings_.kept_every()});
}

LastSeconds::Left LastSeconds::crash_rings(std::vector<KeptFile> files) {
  Left out;
  for (KeptFile& kept : files) {
    const auto id = camera_in(kept.name);
    try {
      if (!id) throw ClipError("its name is not that of last seconds");
      auto ring = kept_as(kept.name, std::make_unique<ImageRing>(std::move(kept.file)));
      if (ring->extent().frames > 0) out.rings.push_back({.camera_id = *id, .ring = std::move(ring)});
    } catch (const ClipError& error) {
      out.was_read = out.was_read || dynamic_cast<const RingWasRead*>(&error) != nullptr;
      log::info("memory of the previous run, {}, is not used: {}", kept.name, error.what());
      forget_file(kept.name);
    }
  }
  return out;
}

std::vector<LastSeconds::Ring> LastSeconds::rings() const {
  std::vector<Ring> out;
  const std::lock_guard lock(mutex_);
  for (const auto& [id, known] : known_) {
    if (!known.ring) continue;
    // If only every n-th image is kept, the ring receives less data than the camera sends.
    const ImageRing::Extent extent = known.ring->extent();
    const double seconds = static_cast<double>(extent.newest_ns - extent.oldest_ns) * 1e-9;
    const double kept_per_s =
        seconds > 0 ? static_cast<double>(known.ring->bytes()) / seconds : known.bytes_per_s;
    out.push_back({id, known.ring, std::min(known.bytes_per_s, kept_per_s)});
  }
  return out;
}

LastSeconds::Status LastSeconds::status() const {
  Status out;
  const std::lock_guard lock(mutex_);
  out.settings = settings_;
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
  out.wanted_bytes = std::max(wanted_bytes_, out.bytes);
  return out;
}

}  // namespace sslv
