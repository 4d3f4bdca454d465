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

/// A change to a table, and its author.
struct TableStep {
  std::string what, who;
  std::int64_t time_us = 0;  // Unix time
  std::vector<CellRun> changes;
  Prints prints_before{}, prints_after{};
};

/// Steps that can be undone and redone. Bounded: the oldest steps are dropped.
class TableHistory {
 public:
  static constexpr std::size_t kMaxSteps = 500, kMaxBytes = 32U << 20;

  /// Adds a step that was just made. Undone steps cannot be redone any more.
  void add(TableStep step);

  bool can_undo() const { return !done_.empty(); }
  bool can_redo() const { return !undone_.empty(); }
  /// The newest step is last.
  const std::deque<TableStep>& done() const { return done_; }
  /// The next step to redo is last.
  const std::vector<TableStep>& undone() const { return undone_; }

  /// Reverts the newest step: the prints, and the cells that still have the label that the step wrote.
  /// Returns the changes; nullopt if there is nothing to undo.
  std::optional<std::vector<CellRun>> undo(ColorTable& table);
  std::optional<std::vector<CellRun>> redo(ColorTable& table);
  void clear();

 private:
  std::deque<TableStep> done_;
  std::vector<TableStep> undone_;
  std::size_t bytes_ = 0;  // memory of all steps
};

}  // namespace sslv
