// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera_pipeline.h"

namespace sslv {
namespace {

/// Clears the stages' results but keeps their memory. Otherwise a part that a changed stack no longer writes
/// would still hold the results of the slot's previous frame.
void forget_results(Frame& frame) {
  frame.labels.width = frame.labels.height = 0;
  frame.runs.width = frame.runs.height = 0;
  frame.runs.runs.clear();
  frame.runs.flood = {};
  frame.runs.cut.clear();
  frame.regions.regions.clear();
  frame.regions.begin = {};
  frame.regions.capped = false;
  frame.robots.robots.clear();
  frame.robots.second_robots.clear();
  frame.robots.misses.clear();
  frame.robots.capped = false;
  frame.balls.balls.clear();
  frame.balls.capped = false;
}

}  // namespace

CameraPipeline::CameraPipeline(std::uint32_t camera_id, DetectionSink& sink, CameraSetup setup,
                               FrameObserver* observer)
    : camera_id_(camera_id), sink_(sink), observer_(observer), setup_(std::move(setup)) {}

const Frame& CameraPipeline::process(Image image, const CaptureTimes& times,
                                     const WholePicture& whole) noexcept {
  const auto setup = setup_.use();
  current_ = ring_.acquire();
  Frame& frame = current_ ? *current_ : spare_;
  frame.info = {camera_id_, next_number_++, times, whole};
  frame.image = std::move(image);
  forget_results(frame);
  if (observer_ != nullptr) observer_->frame_begins(*setup);
  setup->pipeline->run({frame, setup->context, sink_}, setup->parameters);
  if (observer_ != nullptr) observer_->frame_ends(frame, *setup);

  counters_.add(frame);
  if (current_) {
    finished_.put(current_);
    ring_.give_back();  // gives back at least the replaced frame, unless a viewer holds it
  } else {
    frame.image = Image();
    counters_.add_unseen();
  }
  return frame;
}

bool CameraPipeline::give_back() noexcept {
  const std::size_t ours = current_ ? 1 : 0;
  return ring_.give_back() > ours;
}

void CameraPipeline::close() {
  finished_.close();
  current_.reset();
  ring_.give_back();
}

void CameraPipeline::FrameCounters::add(const Frame& frame) noexcept {
  const std::uint64_t frames = frames_.fetch_add(1, std::memory_order_relaxed) + 1;
  const bool is_flooded = frame.runs.flood.blocks > 0;
  if (is_flooded) {
    flood_.store(frame.runs.flood, std::memory_order_relaxed);
    flood_frame_.store(frames, std::memory_order_release);
  }
  if (is_flooded || frame.regions.capped || frame.robots.capped || frame.balls.capped)
    capped_.fetch_add(1, std::memory_order_relaxed);
  robots_.store(static_cast<std::uint32_t>(frame.robots.robots.size()), std::memory_order_relaxed);
  balls_.store(static_cast<std::uint32_t>(frame.balls.balls.size()), std::memory_order_relaxed);
}

CameraPipeline::Counters CameraPipeline::FrameCounters::load() const {
  // The flood's frame is read first, so it is no later than `frames`.
  const std::uint64_t flood_frame = flood_frame_.load(std::memory_order_acquire);
  const std::uint64_t frames = frames_.load(std::memory_order_relaxed);
  return {.frames = frames,
          .capped = capped_.load(std::memory_order_relaxed),
          .unseen = unseen_.load(std::memory_order_relaxed),
          .robots = robots_.load(std::memory_order_relaxed),
          .balls = balls_.load(std::memory_order_relaxed),
          .flood = flood_.load(std::memory_order_relaxed),
          .frames_since_flood = frames - flood_frame};
}

}  // namespace sslv
