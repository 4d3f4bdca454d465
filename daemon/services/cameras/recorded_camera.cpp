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

/// How often a clip may begin: there the stages' memory is kept too.
constexpr std::int64_t kKeyInterval_ns = 250'000'000;
/// A whole image is kept more rarely when parts of the others do.
constexpr std::int64_t kWholeInterval_ns = 1'000'000'000;
/// The fits look at samples beside a region's pixels.
constexpr int kAroundRegionPx = 12;
/// Room for what the stages of a stack remember; they take a few kB.
constexpr std::size_t kMemoryBytes = 256 * 1024;
constexpr std::size_t kMaxTiles = 16384 / 32 * (16384 / 32);

bool is_of_pattern_or_ball(Label color) {
  return color != label::kClear && color != label::kField && color != label::kWhite && color != label::kBlack;
}

bool is_like(const ImageView& a, const ImageView& b) {
  return a.width == b.width && a.height == b.height && a.format == b.format &&
         (a.to_low_bits != 0) == (b.to_low_bits != 0);
}

}  // namespace

RecordedCamera::RecordedCamera(int id, const DetectionSender& sender, Clock now_ns)
    : id_(id),
      sender_(sender),
      now_ns_(std::move(now_ns)),
      memory_(kMemoryBytes),
      tiles_(kMaxTiles / 8),
      key_(kMaxTiles / 8) {}

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
  is_kept_ = kept->images != RecordedFrames::Images::kEveryNth ||
             count_++ % static_cast<std::uint64_t>(kept->every_nth) == 0;
  if (!is_kept_) return;
  const std::int64_t now_ns = now_ns_();
  is_key_ = ring_ != kept->ring.get() || images_ != kept->images || pipeline_ != setup.pipeline.get() ||
            now_ns >= next_key_ns_;
  if (!is_key_) return;
  ring_ = kept->ring.get();
  images_ = kept->images;
  pipeline_ = setup.pipeline.get();
  const bool is_in_parts = kept->images == RecordedFrames::Images::kFound;
  next_key_ns_ = now_ns + (is_in_parts ? kWholeInterval_ns : kKeyInterval_ns);
  memory_bytes_ = setup.pipeline->save(memory_);
}

void RecordedCamera::frame_ends(const Frame& frame, const CameraSetup& setup) noexcept {
  const ImageView& image = frame.image.view();
  frames_seen_.fetch_add(1, std::memory_order_relaxed);
  bytes_seen_.fetch_add(static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height) *
                            static_cast<std::uint64_t>(bytes_per_pixel(image.format)) *
                            (image.to_low_bits != 0 ? 2U : 1U),
                        std::memory_order_relaxed);
  const auto kept = frames_.use();
  if (!kept->ring || kept->ring.get() != ring_ || !is_kept_) return;  // a new ring begins with the next frame
  ClipFrame out{.info = frame.info,
                .setup = setup.number,
                .image = image,
                .packet = sender_.packet_of(frame.info.number),
                .memory = std::span(memory_).first(memory_bytes_)};
  if (kept->images == RecordedFrames::Images::kFound) {
    const std::size_t bytes = mark_tiles(frame);
    if (is_key_ || !is_like(image, key_view_)) {
      std::copy_n(tiles_.begin(), bytes, key_.begin());
      key_view_ = image;
    } else {
      out.tile_px = kTilePx;
      out.tiles = std::span(tiles_).first(bytes);
      // What was there in the whole image and has gone must not seem to be there still.
      for (std::size_t i = 0; i < bytes; ++i) tiles_[i] |= key_[i];
    }
  }
  if (!ring_->put(out) && out.tile_px == 0) key_view_ = {};  // parts need a whole one before them
}

/// Bytes of `tiles_` that count.
std::size_t RecordedCamera::mark_tiles(const Frame& frame) noexcept {
  const ImageView& image = frame.image.view();
  const ClipTiles tiles{image.width, image.height, kTilePx};
  const std::size_t bytes = tiles.map_bytes();
  std::fill_n(tiles_.begin(), bytes, std::byte{0});
  const int columns = tiles.columns(), rows = tiles.rows();
  const auto tile_of = [](int px, int count) { return std::clamp(px / kTilePx, 0, count - 1); };
  for (const Region& region : frame.regions.regions) {
    if (!is_of_pattern_or_ball(region.label)) continue;
    const int left = tile_of(region.left - kAroundRegionPx, columns);
    const int right = tile_of(region.right + kAroundRegionPx, columns);
    const int top = tile_of(region.top - kAroundRegionPx, rows);
    const int bottom = tile_of(region.bottom + kAroundRegionPx, rows);
    for (int row = top; row <= bottom; ++row) {
      for (int column = left; column <= right; ++column) {
        const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                        static_cast<std::size_t>(column);
        tiles_[at / 8] |= std::byte{1} << (at % 8);
      }
    }
  }
  return bytes;
}

void RecordedCamera::keep(RecordedFrames frames) {
  std::shared_ptr<ImageRing> before;  // goes after the lock
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

std::optional<ClipSetup> RecordedCamera::for_clip(const Setup& setup) const {
  if (!setup.config) return std::nullopt;
  const auto& cameras = setup.config->cameras;
  const auto camera = std::ranges::find(cameras, id_, &CameraSettings::id);
  if (camera == cameras.end()) return std::nullopt;
  return clip_setup(*setup.config, static_cast<std::size_t>(camera - cameras.begin()), *setup.setup);
}

/// At once, not when a clip wants it: after a crash nobody could any more.
void RecordedCamera::put_into_ring(const Setup& setup) {
  if (!ring_of_setups_) return;
  try {
    if (const auto made = for_clip(setup)) ring_of_setups_->put_setup(setup.setup->number, *made);
  } catch (const std::exception& error) {
    log::warning("camera {}: a clip after a crash would lack its settings: {}", id_, error.what());
  }
}

std::optional<RecordedCamera::Setup> RecordedCamera::setup(std::uint32_t number) const {
  const std::lock_guard lock(mutex_);
  const auto found = std::ranges::find(setups_, number, [](const Setup& one) { return one.setup->number; });
  if (found == setups_.end()) return std::nullopt;
  return *found;
}

std::optional<ClipSetup> RecordedCamera::setup_for_clip(std::uint32_t number) const {
  const auto found = setup(number);
  return found ? for_clip(*found) : std::nullopt;
}

void RecordedCamera::forget_before(std::uint32_t number) {
  std::vector<Setup> gone;  // tables are freed after the lock
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
