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

// What one can do to a table. Colours and radii are in 8-bit levels, ordered y, u, v, whatever the table's
// bits; a place belongs to the cell it lies in, and a radius counts from the middle of that cell.

using Levels = std::array<int, 3>;  // y, u, v

/// Which cells an edit may take.
enum class Over {
  kAny,
  kClear,  // only those that are clear
};
enum class Shape { kBall, kBox };

struct PaintEdit {
  Label label;
  Levels at, radius;
  Shape shape = Shape::kBall;
  Over over = Over::kAny;
};
/// Makes clear.
struct EraseEdit {
  Levels at, radius;
  Shape shape = Shape::kBall;
  std::optional<Label> only = {};  // absent: whatever is there
};
/// Flood fill: the cells of one label that hang together with the one at `at`, by their faces.
struct FillEdit {
  Label label;
  Levels at;
  bool all_lumas = false;  // else only in the slice of that Y
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
/// A cell that most of its 26 neighbours outvote changes sides: single cells go, holes close, edges even out.
/// Only clear cells become the label's.
struct SmoothEdit {
  Label label;
};
struct ReplaceEdit {
  Label from, to;
};
/// Makes all of a label clear.
struct RemoveEdit {
  Label label;
};
/// The colours of a thing: pixels of it, or what they are like.
struct ColorCluster {
  std::vector<Yuv> pixels;
  /// Instead of pixels.
  struct Spread {
    std::array<double, 3> mean;                       // y, u, v
    std::array<std::array<double, 3>, 3> covariance;  // of y, u, v
  };
  std::optional<Spread> spread = {};
};
/// Cells in the ellipsoid of the cluster; outliers among pixels do not count.
struct AddClusterEdit {
  Label label;
  ColorCluster cluster;
  Over over = Over::kAny;
  /// Clear cells of such colours stay clear; absent: none do. When all of the cluster has them, somebody
  /// pointed at just that, and none do either.
  SurfaceReach stays_clear = {};
};
struct RemoveClusterEdit {
  std::optional<Label> only = {};  // absent: whatever is there
  ColorCluster cluster;
};
/// Makes clear what carpet and floor have, or would have in the light of the range. The floor and other
/// surfaces take no colour that is typical of its label.
struct WidenMarginsEdit {
  std::shared_ptr<const SurfaceColors> surfaces;
  ClearRange range = {};
};
/// A whole table takes the place of this: learnt, imported, copied. Of the same bits.
struct SetTableEdit {
  ColorTable table;
  std::string what;  // "imported robots.lut"
};

using TableEdit = std::variant<PaintEdit, EraseEdit, FillEdit, GrowEdit, ShrinkEdit, SmoothEdit, ReplaceEdit,
                               RemoveEdit, AddClusterEdit, RemoveClusterEdit, WidenMarginsEdit, SetTableEdit>;

/// Reads e.g. {"op": "paint", "label": "pink", "shape": "ball", "at": [131, 148, 216], "radius": [8, 4, 4],
/// "over": "clear"}. All but what takes a table or surfaces can be read. Throws SettingsError, beginning with
/// `path`: key, value, what is allowed.
TableEdit read_table_edit(const Json& json, const std::string& path,
                          const LabelSet& labels = LabelSet::built_in());

/// For people: "painted pink".
std::string what_it_did(const TableEdit& edit, const LabelSet& labels = LabelSet::built_in());

/// Edits the table and says what changed, ordered by cell; nothing for an edit without effect. A label that
/// gets cells has no print any more: its cells tell what it looks like. Throws SettingsError when a set table
/// has other bits.
std::vector<CellRun> apply_edit(ColorTable& table, const TableEdit& edit);

/// How many cells of the cluster stay clear by `stays_clear` when the edit is applied to this table.
std::size_t cells_left_clear(const ColorTable& table, const AddClusterEdit& edit);

/// What it takes to turn one table into another of the same bits.
std::vector<CellRun> difference(const ColorTable& from, const ColorTable& to);

/// Two colours that meet in the table: a little noise turns one into the other.
struct TableConflict {
  Label a = 0, b = 0;       // a < b
  std::size_t cells = 0;    // of either that have the other for a neighbour
  std::vector<Yuv> places;  // the first of them: middles of cells of `a`
};
struct TableStatistics {
  std::array<std::size_t, label::kMaxCount> cells{};  // of each label
  std::vector<TableConflict> conflicts;               // the largest first
};
/// Up to `max_places` places for each pair. Field, white, black and clear are no colours here.
TableStatistics table_statistics(const ColorTable& table, std::size_t max_places = 50);

}  // namespace sslv
