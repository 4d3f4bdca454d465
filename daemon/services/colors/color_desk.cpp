// SPDX-License-Identifier: Apache-2.0
#include "services/colors/color_desk.h"

#include "base/clock.h"

#include <array>
#include <cmath>
#include <utility>
#include <variant>

namespace sslv {

void ColorDesk::take(std::shared_ptr<const Lut> accepted) {
  if (accepted == table_) return;
  // The same table, loaded again: keep the history.
  if (table_ && accepted->color_table() == table_->color_table()) {
    table_ = std::move(accepted);
    return;
  }
  history_.clear();
  put(std::move(accepted));
}

void ColorDesk::put(std::shared_ptr<const Lut> lut) {
  table_ = std::move(lut);
  ++revision_;
}

const TableStatistics& ColorDesk::statistics() {
  if (counted_ != table_->id()) {
    statistics_ = table_statistics(table_->color_table());
    counted_ = table_->id();
  }
  return statistics_;
}

TableChange ColorDesk::preview(std::span<const TableEdit> edits) const {
  const ColorTable before = table_->color_table();
  ColorTable after = before;
  std::vector<CellRun> cells;
  std::size_t left_clear = 0;
  for (const TableEdit& edit : edits) {
    if (const auto* add = std::get_if<AddClusterEdit>(&edit)) left_clear += cells_left_clear(after, *add);
    cells = apply_edit(after, edit);
  }
  if (edits.size() != 1) cells = difference(before, after);
  if (cells.empty()) return {table_, {}, left_clear};
  return {std::make_shared<const Lut>(table_->with_changes(cells, after.prints)), std::move(cells),
          left_clear};
}

void ColorDesk::change(const TableChange& change, const std::string& what, const std::string& who,
                       const Save& save) {
  if (change.cells.empty()) return;
  save(change.lut, what);
  history_.add(
      {what, who, std::llround(unix_time_s() * 1e6), change.cells, table_->prints(), change.lut->prints()});
  put(change.lut);
}

void ColorDesk::replace(std::shared_ptr<const Lut> lut, const std::string& what, const std::string& who,
                        const Save& save) {
  if (lut->color_bits() == table_->color_bits()) {
    auto cells = difference(table_->color_table(), lut->color_table());
    change({std::move(lut), std::move(cells), 0}, what, who, save);
    return;
  }
  save(lut, what);
  history_.clear();
  put(std::move(lut));
}

bool ColorDesk::undo(const Save& save) {
  if (!history_.can_undo()) return false;
  const std::string what = history_.done().back().what;
  ColorTable table = table_->color_table();
  const auto cells = history_.undo(table);
  const auto lut = std::make_shared<const Lut>(table_->with_changes(*cells, table.prints));
  try {
    save(lut, "undone: " + what);
  } catch (...) {
    history_.redo(table);
    throw;
  }
  put(lut);
  return true;
}

bool ColorDesk::redo(const Save& save) {
  if (!history_.can_redo()) return false;
  const std::string what = history_.undone().back().what;
  ColorTable table = table_->color_table();
  const auto cells = history_.redo(table);
  const auto lut = std::make_shared<const Lut>(table_->with_changes(*cells, table.prints));
  try {
    save(lut, what);
  } catch (...) {
    history_.undo(table);
    throw;
  }
  put(lut);
  return true;
}

std::vector<std::pair<Label, std::size_t>> cells_before(std::span<const CellRun> runs) {
  std::array<std::size_t, label::kMaxCount> counts{};
  for (const CellRun& run : runs) counts[run.before] += run.length;
  std::vector<std::pair<Label, std::size_t>> out;
  for (std::size_t label = 0; label < counts.size(); ++label) {
    if (counts[label] > 0) out.emplace_back(static_cast<Label>(label), counts[label]);
  }
  return out;
}

}  // namespace sslv
