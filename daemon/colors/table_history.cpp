// SPDX-License-Identifier: Apache-2.0
#include "colors/table_history.h"

#include <utility>

namespace sslv {
namespace {

std::size_t bytes_of(const TableStep& step) {
  return sizeof(step) + step.what.size() + step.who.size() + step.changes.size() * sizeof(CellRun);
}

/// Changes the run's cells with label `from` to label `to`, and appends them to `changed`.
void set_cells(ColorTable& table, const CellRun& run, Label from, Label to, std::vector<CellRun>& changed) {
  for (std::uint32_t cell = run.begin; cell < run.begin + run.length; ++cell) {
    if (table.labels[cell] != from) continue;
    table.labels[cell] = to;
    CellRun* const last = changed.empty() ? nullptr : &changed.back();
    if (last != nullptr && last->begin + last->length == cell && last->before == from && last->after == to) {
      ++last->length;
    } else {
      changed.push_back({cell, 1, from, to});
    }
  }
}

}  // namespace

void TableHistory::add(TableStep step) {
  for (const TableStep& gone : undone_) bytes_ -= bytes_of(gone);
  undone_.clear();
  bytes_ += bytes_of(step);
  done_.push_back(std::move(step));
  while (!done_.empty() && (done_.size() > kMaxSteps || bytes_ > kMaxBytes)) {
    bytes_ -= bytes_of(done_.front());
    done_.pop_front();
  }
}

std::optional<std::vector<CellRun>> TableHistory::undo(ColorTable& table) {
  if (done_.empty()) return std::nullopt;
  std::vector<CellRun> changed;
  for (const CellRun& run : done_.back().changes) set_cells(table, run, run.after, run.before, changed);
  table.prints = done_.back().prints_before;
  undone_.push_back(std::move(done_.back()));
  done_.pop_back();
  return changed;
}

std::optional<std::vector<CellRun>> TableHistory::redo(ColorTable& table) {
  if (undone_.empty()) return std::nullopt;
  std::vector<CellRun> changed;
  for (const CellRun& run : undone_.back().changes) set_cells(table, run, run.before, run.after, changed);
  table.prints = undone_.back().prints_after;
  done_.push_back(std::move(undone_.back()));
  undone_.pop_back();
  return changed;
}

void TableHistory::clear() {
  *this = {};
}

}  // namespace sslv
