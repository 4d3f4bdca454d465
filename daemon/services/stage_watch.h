// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipeline/pipeline.h"
#include "pipeline/senseless.h"
#include "pipeline/stage_notes.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace sslv {

/// A stage of a stack, as the last seconds were.
struct StageFigures {
  std::string name;
  std::string library{};    // name of the file that it comes from; empty: it is the service's own
  double mean_ms = 0;       // that it takes for an image, over the newest seconds
  double max_ms = 0;        // over all that are known
  Senseless left_out{};     // likewise: what it made that made no sense
  StageNotes::Note note{};  // what it has to say now
};

/// Looks at a stack once a second. For one thread.
class StageWatch {
 public:
  static constexpr std::size_t kSeconds = 10, kNewestSeconds = 3;

  /// With another pipeline than before, it begins again.
  template <class Floor>
  void look(const std::shared_ptr<BasicPipeline<Floor>>& pipeline);

  /// In the order of the stack, each with what it had to say at the last look.
  const std::vector<StageFigures>& figures() const { return figures_; }

 private:
  struct Second {  // of a stage
    std::uint64_t images = 0;
    double sum_ms = 0, max_ms = 0;
    Senseless left_out;
  };
  struct Seen {  // of a stage, up to the last look
    std::uint64_t images = 0;
    Senseless left_out;
  };
  void sum_up();

  std::weak_ptr<const void> pipeline_;
  std::vector<Seen> seen_;
  std::deque<std::vector<Second>> seconds_;  // the newest last
  std::vector<StageFigures> figures_;
};

}  // namespace sslv
