// SPDX-License-Identifier: Apache-2.0
#include "services/stage_watch.h"

#include "services/stage_report.h"

#include <algorithm>

namespace sslv {
namespace {

InvalidCounts since(const InvalidCounts& before, const InvalidCounts& now) {
  return {now.robots - before.robots, now.balls - before.balls, now.others - before.others};
}

}  // namespace

template <class Floor>
void StageWatch::look(const std::shared_ptr<BasicPipeline<Floor>>& pipeline) {
  const auto& stack = pipeline->stack();
  if (pipeline_.lock() != pipeline) {
    pipeline_ = pipeline;
    seen_.assign(stack.size(), {});
    seconds_.clear();
    figures_.clear();
    for (std::size_t i = 0; i < stack.size(); ++i)
      figures_.push_back({.name = stack[i], .library = library_name(pipeline->library(i))});
  }
  std::vector<Second> second(stack.size());
  for (std::size_t i = 0; i < stack.size(); ++i) {
    // Read the count before the samples: an image that finishes in between is counted again in the next
    // second, but none is missed.
    const std::uint64_t images = pipeline->durations(i).count();
    for (const std::int64_t took_ns : pipeline->durations(i).samples_ns(seen_[i].images)) {
      const double took_ms = static_cast<double>(took_ns) * 1e-6;
      ++second[i].images;
      second[i].sum_ms += took_ms;
      second[i].max_ms = std::max(second[i].max_ms, took_ms);
    }
    const InvalidCounts left_out = pipeline->left_out(i);
    second[i].left_out = since(seen_[i].left_out, left_out);
    seen_[i] = {images, left_out};
    figures_[i].note = pipeline->note(i);
  }
  seconds_.push_back(std::move(second));
  if (seconds_.size() > kSeconds) seconds_.pop_front();
  sum_up();
}

void StageWatch::sum_up() {
  for (std::size_t i = 0; i < figures_.size(); ++i) {
    Second all;
    std::uint64_t newest = 0;
    double newest_ms = 0;
    std::size_t age = seconds_.size();
    for (const auto& second : seconds_) {
      const Second& one = second[i];
      all.images += one.images;
      all.sum_ms += one.sum_ms;
      all.max_ms = std::max(all.max_ms, one.max_ms);
      all.left_out += one.left_out;
      if (age-- > kNewestSeconds) continue;
      newest += one.images;
      newest_ms += one.sum_ms;
    }
    // A stage that takes seconds per image may have finished none in the newest seconds: use all seconds.
    if (newest == 0) {
      newest = all.images;
      newest_ms = all.sum_ms;
    }
    figures_[i].mean_ms = newest > 0 ? newest_ms / static_cast<double>(newest) : 0;
    figures_[i].max_ms = all.max_ms;
    figures_[i].left_out = all.left_out;
  }
}

template void StageWatch::look<CameraFloor>(const std::shared_ptr<Pipeline>&);
template void StageWatch::look<FieldFloor>(const std::shared_ptr<FieldPipeline>&);

}  // namespace sslv
