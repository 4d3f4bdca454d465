// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "colors/table_edit.h"
#include "colors/table_history.h"
#include "vision/label.h"
#include "vision/lut.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sslv {

/// Result of an edit.
struct TableChange {
  std::shared_ptr<const Lut> lut;  // the edited table; the same as before when nothing changes
  std::vector<CellRun> cells;
  std::size_t left_clear = 0;  // cells of added clusters that stay clear because they are carpet colours
};

/// A camera's accepted table and its undo history: the edits of all users, one after the other. Not
/// thread-safe.
class ColorDesk {
 public:
  /// Sets the accepted table. If it differs from the current table, the history is cleared.
  void take(std::shared_ptr<const Lut> accepted);

  const std::shared_ptr<const Lut>& table() const { return table_; }
  /// Increases with each change of the table.
  std::uint64_t revision() const { return revision_; }
  const TableHistory& history() const { return history_; }
  /// Statistics of the table; computed once for each table.
  const TableStatistics& statistics();

  /// Returns the change that these edits together would make. Throws SettingsError.
  TableChange preview(std::span<const TableEdit> edits) const;

  /// The following functions apply a table through `save`. If `save` throws, the desk is unchanged too.
  using Save = std::function<void(const std::shared_ptr<const Lut>& lut, const std::string& what)>;
  /// Adds one undo step, unless nothing changes.
  void change(const TableChange& change, const std::string& what, const std::string& who, const Save& save);
  /// If `lut` has another number of colour bits than the table, the history is cleared.
  void replace(std::shared_ptr<const Lut> lut, const std::string& what, const std::string& who,
               const Save& save);
  /// False when there is nothing to undo or redo.
  bool undo(const Save& save);
  bool redo(const Save& save);

 private:
  void put(std::shared_ptr<const Lut> lut);

  std::shared_ptr<const Lut> table_;
  std::uint64_t revision_ = 0;
  TableHistory history_;
  std::uint64_t counted_ = 0;  // Lut::id of the table of statistics_
  TableStatistics statistics_;
};

/// Number of cells in these runs, by their previous label.
std::vector<std::pair<Label, std::size_t>> cells_before(std::span<const CellRun> runs);

}  // namespace sslv
