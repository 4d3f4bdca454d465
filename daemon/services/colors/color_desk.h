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

/// What an edit changes.
struct TableChange {
  std::shared_ptr<const Lut> lut;  // the table with it; the same as before when nothing changes
  std::vector<CellRun> cells;
  std::size_t left_clear = 0;  // cells that clusters would have taken from a surface
};

/// A camera's accepted table, and what was done to it since it was put on the desk: the edits of all people,
/// one after the other. The caller ensures that one thread uses it at a time.
class ColorDesk {
 public:
  /// Puts this table onto the desk. Another than the one that lies there has no history here.
  void take(std::shared_ptr<const Lut> accepted);

  const std::shared_ptr<const Lut>& table() const { return table_; }
  /// Grows with each change of the table.
  std::uint64_t revision() const { return revision_; }
  const TableHistory& history() const { return history_; }
  /// Of the table; counted once for each.
  const TableStatistics& statistics();

  /// What these edits together would change. Throws SettingsError.
  TableChange preview(std::span<const TableEdit> edits) const;

  /// Each applies a table by `save`; when that throws, nothing has changed here either.
  using Save = std::function<void(const std::shared_ptr<const Lut>& lut, const std::string& what)>;
  /// One step of undo; none when nothing changes.
  void change(const TableChange& change, const std::string& what, const std::string& who, const Save& save);
  /// Of whatever bits: the steps before it cannot be undone here any more when they differ.
  void replace(std::shared_ptr<const Lut> lut, const std::string& what, const std::string& who,
               const Save& save);
  /// False when there is nothing to undo, to do again.
  bool undo(const Save& save);
  bool redo(const Save& save);

 private:
  void put(std::shared_ptr<const Lut> lut);

  std::shared_ptr<const Lut> table_;
  std::uint64_t revision_ = 0;
  TableHistory history_;
  std::uint64_t counted_ = 0;  // Lut::id of the statistics' table
  TableStatistics statistics_;
};

/// How many cells these runs have, by the label before.
std::vector<std::pair<Label, std::size_t>> cells_before(std::span<const CellRun> runs);

}  // namespace sslv
