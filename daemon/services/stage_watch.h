// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/stage_notes.h"
#include "pipeline/pipeline.h"
#include "pipeline/validate.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// Figures of a stage over the last seconds.
struct StageFigures {
  std::string name;
  std::string library{};     // name of its library file; empty: the service's own stage
  double mean_ms = 0;        // per image, over the last kNewestSeconds of StageWatch
  double max_ms = 0;         // largest for one image, over the last kSeconds
  InvalidCounts left_out{};  // results dropped as invalid, over the last kSeconds
  StageNotes::Note note{};   // its current note
};

/// Measures a stack of stages once a second. For one thread only.
class StageWatch {
 public:
  static constexpr std::size_t kSeconds = 10, kNewestSeconds = 3;

  /// Call it once a second. Starts over if it gets another pipeline than before.
  template <class Floor>
  void look(const std::shared_ptr<BasicPipeline<Floor>>& pipeline);

  /// In the order of the stack, each with its note at the last look().
  const std::vector<StageFigures>& figures() const { return figures_; }

 private:
  struct Second {  // figures of a stage in one second
    std::uint64_t images = 0;
    double sum_ms = 0, max_ms = 0;
    InvalidCounts left_out;
  };
  struct Seen {  // state of a stage at the last look()
    std::uint64_t images = 0;
    InvalidCounts left_out;
  };
  void sum_up();

  std::weak_ptr<const void> pipeline_;
  std::vector<Seen> seen_;
  std::deque<std::vector<Second>> seconds_;  // the newest last
  std::vector<StageFigures> figures_;
};

}  // namespace sslv
