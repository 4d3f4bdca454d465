// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "colors/surfaces.h"
#include "image/color.h"
#include "vision/label.h"
#include "vision/lut.h"

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sslv {

// Edits of a table. Colours and radii are in 8-bit levels, ordered y, u, v, independently of the table's
// number of bits. A colour denotes the cell that contains it; radii are measured from the middle of that
// cell.

using Levels = std::array<int, 3>;  // y, u, v

/// The cells that an edit may change.
enum class Over {
  kAny,
  kClear,  // only clear cells
};
enum class Shape { kBall, kBox };

struct PaintEdit {
  Label label;
  Levels at, radius;
  Shape shape = Shape::kBall;
  Over over = Over::kAny;
};
/// Clears cells.
struct EraseEdit {
  Levels at, radius;
  Shape shape = Shape::kBall;
  std::optional<Label> only = {};  // none: any label
};
/// Flood fill of the cells that have the same label as the cell at `at` and are connected to it by their
/// faces.
struct FillEdit {
  Label label;
  Levels at;
  bool all_lumas = false;  // false: only in the slice of that Y
};
struct GrowEdit {
  Label label;
  int cells = 1;
  Over over = Over::kClear;
};
struct ShrinkEdit {
  Label label;
  int cells = 1;
};
/// Majority vote of a cell's 26 neighbours: removes single cells, closes holes, smooths edges. Only clear
/// cells can get the label.
struct SmoothEdit {
  Label label;
};
struct ReplaceEdit {
  Label from, to;
};
/// Clears all cells of a label.
struct RemoveEdit {
  Label label;
};
/// The colours of an object: some of its pixels, or the distribution of its colours.
struct ColorCluster {
  std::vector<Yuv> pixels;
  /// Used instead of pixels.
  struct Spread {
    std::array<double, 3> mean;                       // y, u, v
    std::array<std::array<double, 3>, 3> covariance;  // of y, u, v
  };
  std::optional<Spread> spread = {};
};
/// Adds the cells in the cluster's ellipsoid; outliers among pixels do not count.
struct AddClusterEdit {
  Label label;
  ColorCluster cluster;
  Over over = Over::kAny;
  /// Clear cells of these colours stay clear; empty: none. Ignored if all cells of the cluster have these
  /// colours, because the user then pointed at one of them on purpose.
  SurfaceReach stays_clear = {};
};
struct RemoveClusterEdit {
  std::optional<Label> only = {};  // none: any label
  ColorCluster cluster;
};
/// Clears the cells with colours that carpet and floor have, or would have in light within the range. Cells
/// whose colour is typical of their label are not cleared because of the floor or other surfaces.
struct WidenMarginsEdit {
  std::shared_ptr<const SurfaceColors> surfaces;
  ClearRange range = {};
};
/// Replaces the table by a learnt, imported or copied table with the same number of bits.
struct SetTableEdit {
  ColorTable table;
  std::string what;  // "imported robots.lut"
};

using TableEdit = std::variant<PaintEdit, EraseEdit, FillEdit, GrowEdit, ShrinkEdit, SmoothEdit, ReplaceEdit,
                               RemoveEdit, AddClusterEdit, RemoveClusterEdit, WidenMarginsEdit, SetTableEdit>;

/// Reads an edit such as {"op": "paint", "label": "pink", "shape": "ball", "at": [131, 148, 216], "radius":
/// [8, 4, 4], "over": "clear"}. WidenMarginsEdit and SetTableEdit cannot be read. Throws SettingsError with
/// `path`, the key, the value and the allowed values.
TableEdit read_table_edit(const Json& json, const std::string& path,
                          const LabelSet& labels = LabelSet::built_in());

/// For the user: "painted pink".
std::string what_it_did(const TableEdit& edit, const LabelSet& labels = LabelSet::built_in());

/// Edits the table and returns the changes, ordered by cell; empty for an edit without effect. A label that
/// gets cells loses its print, because then its cells describe its colours. Throws SettingsError if a
/// SetTableEdit has another number of bits.
std::vector<CellRun> apply_edit(ColorTable& table, const TableEdit& edit);

/// Number of cells of the cluster that `stays_clear` keeps clear when the edit is applied to this table.
std::size_t cells_left_clear(const ColorTable& table, const AddClusterEdit& edit);

/// Changes that turn one table into another one with the same number of bits.
std::vector<CellRun> difference(const ColorTable& from, const ColorTable& to);

/// Two labels that touch in the table: a little noise turns one into the other.
struct TableConflict {
  Label a = 0, b = 0;       // a < b
  std::size_t cells = 0;    // number of cells next to a cell of the other label
  std::vector<Yuv> places;  // middles of the first cells of `a` next to `b`
};
struct TableStatistics {
  std::array<std::size_t, label::kMaxCount> cells{};  // number of cells of each label
  std::vector<TableConflict> conflicts;               // largest conflict first
};
/// Lists up to `max_places` places for each pair. Field, white, black and clear cause no conflicts.
TableStatistics table_statistics(const ColorTable& table, std::size_t max_places = 50);

}  // namespace sslv
