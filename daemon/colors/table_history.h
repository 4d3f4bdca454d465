// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/lut.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// A change of a table that was made, and by whom.
struct TableStep {
  std::string what, who;
  std::int64_t time_us = 0;  // since 1970
  std::vector<CellRun> changes;
  Prints prints_before{}, prints_after{};
};

/// Steps that can be undone and done again. Bounded: beyond that the oldest are forgotten.
class TableHistory {
 public:
  static constexpr std::size_t kMaxSteps = 500, kMaxBytes = 32U << 20;

  /// A step that was just made. What was undone before it cannot be redone any more.
  void add(TableStep step);

  bool can_undo() const { return !done_.empty(); }
  bool can_redo() const { return !undone_.empty(); }
  /// The newest last.
  const std::deque<TableStep>& done() const { return done_; }
  /// The next to be redone last.
  const std::vector<TableStep>& undone() const { return undone_; }

  /// Sets back the prints, and the cells that still hold what the newest step wrote; says what changed.
  /// Nothing to undo: no value.
  std::optional<std::vector<CellRun>> undo(ColorTable& table);
  std::optional<std::vector<CellRun>> redo(ColorTable& table);
  void clear();

 private:
  std::deque<TableStep> done_;
  std::vector<TableStep> undone_;
  std::size_t bytes_ = 0;  // of all steps
};

}  // namespace sslv
