// SPDX-License-Identifier: Apache-2.0
#include "colors/table_edit.h"

#include "base/error.h"
#include "base/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <utility>

#include <Eigen/Core>
#include <Eigen/LU>
#include <fmt/format.h>

namespace sslv {
namespace {

/// A cell by its index in each channel.
struct Cell {
  int y, u, v;
};

std::size_t index_of(const ColorTable& table, const Cell& cell) {
  return (static_cast<std::size_t>(cell.u) << (2 * table.bits)) |
         (static_cast<std::size_t>(cell.v) << table.bits) | static_cast<std::size_t>(cell.y);
}
Cell cell_at(const ColorTable& table, std::size_t index) {
  const std::size_t mask = (std::size_t{1} << table.bits) - 1;
  return {static_cast<int>(index & mask), static_cast<int>(index >> (2 * table.bits)),
          static_cast<int>(index >> table.bits & mask)};
}
/// Width of a cell in 8-bit levels.
int step_of(const ColorTable& table) {
  return 256 >> table.bits;
}
Cell cell_of(const ColorTable& table, const Levels& at) {
  const int step = step_of(table);
  return {at[0] / step, at[1] / step, at[2] / step};
}

/// Sets cells in ascending order and records the changes.
class Brush {
 public:
  explicit Brush(ColorTable& table) : table_(table) {}

  void set(std::size_t cell, Label after) {
    const Label before = std::exchange(table_.labels[cell], after);
    if (before == after) return;
    if (!runs_.empty()) {
      CellRun& last = runs_.back();
      if (last.begin + last.length == cell && last.before == before && last.after == after) {
        ++last.length;
        return;
      }
    }
    runs_.push_back({static_cast<std::uint32_t>(cell), 1, before, after});
  }
  std::vector<CellRun> take() { return std::move(runs_); }

 private:
  ColorTable& table_;
  std::vector<CellRun> runs_;
};

/// Box of cells from low to high, both included.
struct CellBox {
  Cell low, high;

  bool empty() const { return low.u > high.u; }
  std::size_t size() const {
    return static_cast<std::size_t>(high.u - low.u + 1) * static_cast<std::size_t>(high.v - low.v + 1) *
           static_cast<std::size_t>(row());
  }
  int row() const { return high.y - low.y + 1; }
  /// Index of the row of cells (low.y .. high.y, u, v) in an array of the box's cells.
  std::size_t row_at(int u, int v) const {
    return static_cast<std::size_t>((u - low.u) * (high.v - low.v + 1) + (v - low.v)) *
           static_cast<std::size_t>(row());
  }
  CellBox grown(int by, int side) const {
    return {
        {std::max(0, low.y - by), std::max(0, low.u - by), std::max(0, low.v - by)},
        {std::min(side - 1, high.y + by), std::min(side - 1, high.u + by), std::min(side - 1, high.v + by)}};
  }
};

/// Calls `call` with each cell's index in the table and the cell, in ascending order.
template <class Call>
void for_cells(const ColorTable& table, const CellBox& box, const Call& call) {
  for (int u = box.low.u; u <= box.high.u; ++u) {
    for (int v = box.low.v; v <= box.high.v; ++v) {
      const std::size_t row = index_of(table, {0, u, v});
      for (int y = box.low.y; y <= box.high.y; ++y) {
        const Cell cell{y, u, v};
        call(row + static_cast<std::size_t>(y), cell);
      }
    }
  }
}

CellBox box_of(const ColorTable& table, Label label) {
  const int side = table.side();
  CellBox box{{side, side, side}, {-1, -1, -1}};
  for (int u = 0; u < side; ++u) {
    for (int v = 0; v < side; ++v) {
      const auto row = table.labels.begin() + static_cast<std::ptrdiff_t>(index_of(table, {0, u, v}));
      const auto first = std::find(row, row + side, label);
      if (first == row + side) continue;
      int last = side - 1;
      while (row[last] != label) --last;
      box.low = {std::min(box.low.y, static_cast<int>(first - row)), std::min(box.low.u, u),
                 std::min(box.low.v, v)};
      box.high = {std::max(box.high.y, last), std::max(box.high.u, u), std::max(box.high.v, v)};
    }
  }
  return box;
}

// ---- brushes

template <class Call>
void for_cells_of_shape(const ColorTable& table, Shape shape, const Levels& at, const Levels& radius,
                        const Call& call) {
  const Cell center = cell_of(table, at), reach = cell_of(table, radius);
  const int last = table.side() - 1;
  const CellBox box{
      {std::max(0, center.y - reach.y), std::max(0, center.u - reach.u), std::max(0, center.v - reach.v)},
      {std::min(last, center.y + reach.y), std::min(last, center.u + reach.u),
       std::min(last, center.v + reach.v)}};
  const auto share2 = [step = step_of(table)](int cells, int radius_levels) {
    return cells == 0 ? 0.0 : std::pow(static_cast<double>(cells * step) / radius_levels, 2);
  };
  for_cells(table, box, [&](std::size_t place, const Cell& cell) {
    if (shape == Shape::kBox || share2(cell.y - center.y, radius[0]) + share2(cell.u - center.u, radius[1]) +
                                        share2(cell.v - center.v, radius[2]) <=
                                    1 + 1e-9)
      call(place);
  });
}

void apply(const PaintEdit& edit, ColorTable& table, Brush& brush) {
  for_cells_of_shape(table, edit.shape, edit.at, edit.radius, [&](std::size_t place) {
    if (edit.over == Over::kAny || table.labels[place] == label::kClear) brush.set(place, edit.label);
  });
}

void apply(const EraseEdit& edit, ColorTable& table, Brush& brush) {
  for_cells_of_shape(table, edit.shape, edit.at, edit.radius, [&](std::size_t place) {
    if (!edit.only || table.labels[place] == *edit.only) brush.set(place, label::kClear);
  });
}

void apply(const FillEdit& edit, ColorTable& table, Brush& brush) {
  const Cell from = cell_of(table, edit.at);
  const Label old = table.labels[index_of(table, from)];
  if (old == edit.label) return;
  std::vector<bool> found(table.labels.size());
  std::vector<std::size_t> open;  // found cells whose neighbours were not visited yet
  const auto look_at = [&](const Cell& cell) {
    const int last = table.side() - 1;
    if (std::min({cell.y, cell.u, cell.v}) < 0 || std::max({cell.y, cell.u, cell.v}) > last) return;
    const std::size_t place = index_of(table, cell);
    if (found[place] || table.labels[place] != old) return;
    found[place] = true;
    open.push_back(place);
  };
  look_at(from);
  while (!open.empty()) {
    const Cell cell = cell_at(table, open.back());
    open.pop_back();
    for (const int off : {-1, 1}) {
      look_at({cell.y, cell.u + off, cell.v});
      look_at({cell.y, cell.u, cell.v + off});
      if (edit.all_lumas) look_at({cell.y + off, cell.u, cell.v});
    }
  }
  for (std::size_t place = 0; place < found.size(); ++place) {
    if (found[place]) brush.set(place, edit.label);
  }
}

// ---- shapes of labels

/// For each cell of the box, the squared distance in cells to the nearest cell whose label `there` accepts;
/// more than most^2 if no such cell is within `most` cells.
template <class There>
std::vector<std::uint16_t> squared_distances(const ColorTable& table, const CellBox& box, int most,
                                             const There& there) {
  const auto far = static_cast<std::uint16_t>((most + 1) * (most + 1));
  const int row = box.row();
  std::vector<std::uint16_t> distance(box.size(), far);
  for (int u = box.low.u; u <= box.high.u; ++u) {
    for (int v = box.low.v; v <= box.high.v; ++v) {
      std::uint16_t* out = distance.data() + box.row_at(u, v);
      const Label* labels = table.labels.data() + index_of(table, {box.low.y, u, v});
      for (const bool back : {false, true}) {
        int steps = most + 1;
        for (int i = 0; i < row; ++i) {
          const int y = back ? row - 1 - i : i;
          steps = there(labels[y]) ? 0 : std::min(steps + 1, most + 1);
          out[y] = std::min(out[y], static_cast<std::uint16_t>(steps * steps));
        }
      }
    }
  }
  // Along the other two channels: a row at distance d adds d^2.
  for (const bool along_u : {false, true}) {
    const std::vector<std::uint16_t> before = distance;
    for (int u = box.low.u; u <= box.high.u; ++u) {
      for (int v = box.low.v; v <= box.high.v; ++v) {
        std::uint16_t* out = distance.data() + box.row_at(u, v);
        const int here = along_u ? u : v;
        const int first = std::max(here - most, along_u ? box.low.u : box.low.v);
        const int last = std::min(here + most, along_u ? box.high.u : box.high.v);
        for (int other = first; other <= last; ++other) {
          if (other == here) continue;
          const auto more = static_cast<std::uint16_t>((other - here) * (other - here));
          const std::uint16_t* in = before.data() + (along_u ? box.row_at(other, v) : box.row_at(u, other));
          for (int y = 0; y < row; ++y) {
            out[y] = std::min(out[y], static_cast<std::uint16_t>(in[y] + more));
          }
        }
      }
    }
  }
  return distance;
}

void apply(const GrowEdit& edit, ColorTable& table, Brush& brush) {
  const CellBox of_label = box_of(table, edit.label);
  if (of_label.empty()) return;
  const CellBox box = of_label.grown(edit.cells, table.side());
  const auto distances =
      squared_distances(table, box, edit.cells, [&](Label label) { return label == edit.label; });
  std::size_t i = 0;
  for_cells(table, box, [&](std::size_t place, const Cell&) {
    if (distances[i++] <= edit.cells * edit.cells &&
        (edit.over == Over::kAny || table.labels[place] == label::kClear))
      brush.set(place, edit.label);
  });
}

void apply(const ShrinkEdit& edit, ColorTable& table, Brush& brush) {
  const CellBox of_label = box_of(table, edit.label);
  if (of_label.empty()) return;
  // Cells around the box count as other labels; beyond the cube, there are no cells.
  const CellBox box = of_label.grown(1, table.side());
  const auto distances =
      squared_distances(table, box, edit.cells, [&](Label label) { return label != edit.label; });
  std::size_t i = 0;
  for_cells(table, box, [&](std::size_t place, const Cell&) {
    if (distances[i++] <= edit.cells * edit.cells && table.labels[place] == edit.label)
      brush.set(place, label::kClear);
  });
}

void apply(const SmoothEdit& edit, ColorTable& table, Brush& brush) {
  const CellBox of_label = box_of(table, edit.label);
  if (of_label.empty()) return;
  const CellBox box = of_label.grown(1, table.side());
  std::vector<std::uint8_t> votes(box.size());  // cells with the label in the 3 x 3 x 3 around each cell
  const auto row = static_cast<std::size_t>(box.row());
  std::size_t i = 0;
  for_cells(table, box,
            [&](std::size_t place, const Cell&) { votes[i++] = table.labels[place] == edit.label; });
  // Sums 3 x 3 x 3 cells, one channel after the other.
  const auto add_neighbours = [&](std::size_t stride, auto place_in_channel, int last) {
    const std::vector<std::uint8_t> alone = votes;
    for (std::size_t k = 0; k < votes.size(); ++k) {
      const int at = place_in_channel(k);
      int sum = alone[k];
      if (at > 0) sum += alone[k - stride];
      if (at < last) sum += alone[k + stride];
      votes[k] = static_cast<std::uint8_t>(sum);
    }
  };
  const auto rows = static_cast<std::size_t>(box.high.v - box.low.v + 1);
  add_neighbours(
      1, [&](std::size_t k) { return static_cast<int>(k % row); }, box.row() - 1);
  add_neighbours(
      row, [&](std::size_t k) { return static_cast<int>(k / row % rows); }, box.high.v - box.low.v);
  add_neighbours(
      row * rows, [&](std::size_t k) { return static_cast<int>(k / (row * rows)); }, box.high.u - box.low.u);
  const auto width = [last = table.side() - 1](int at) { return at == 0 || at == last ? 2 : 3; };
  i = 0;
  for_cells(table, box, [&](std::size_t place, const Cell& cell) {
    const bool is_label = table.labels[place] == edit.label;
    const int neighbours = width(cell.y) * width(cell.u) * width(cell.v) - 1;
    const int alike = votes[i++] - (is_label ? 1 : 0);
    if (is_label && 2 * alike < neighbours) brush.set(place, label::kClear);
    if (!is_label && table.labels[place] == label::kClear && 2 * alike > neighbours)
      brush.set(place, edit.label);
  });
}

void replace(ColorTable& table, Label from, Label to, Brush& brush) {
  for (std::size_t place = 0; place < table.labels.size(); ++place) {
    if (table.labels[place] == from) brush.set(place, to);
  }
}

void apply(const ReplaceEdit& edit, ColorTable& table, Brush& brush) {
  replace(table, edit.from, edit.to, brush);
}

void apply(const RemoveEdit& edit, ColorTable& table, Brush& brush) {
  replace(table, edit.label, label::kClear, brush);
}

// ---- clusters

/// Cells within this many standard deviations of a cluster's middle belong to it.
constexpr double kReach = 3;
/// Pixels beyond this squared Mahalanobis distance are outliers: 1 % of a normal distribution in three
/// dimensions.
constexpr double kOutlier2 = 11.34;
constexpr int kRounds = 4;

struct Ellipsoid {
  Eigen::Vector3d mean;  // y, u, v
  Eigen::Matrix3d covariance;
};

/// Starts from medians, which withstand up to 50 % outliers, and continues with the pixels that fit.
Ellipsoid ellipsoid_of(const std::vector<Yuv>& pixels, double min_variance) {
  std::vector<Eigen::Vector3d> colors;
  colors.reserve(pixels.size());
  for (const Yuv& c : pixels) colors.emplace_back(c.y, c.u, c.v);
  const Eigen::Matrix3d least = min_variance * Eigen::Matrix3d::Identity();
  Ellipsoid out{Eigen::Vector3d::Zero(), least};
  std::vector<double> values(colors.size());
  for (Eigen::Index k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < colors.size(); ++i) values[i] = colors[i][k];
    out.mean[k] = median(values);
    for (double& value : values) value = std::abs(value - out.mean[k]);
    out.covariance(k, k) += std::pow(1.4826 * median(values), 2);
  }
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Matrix3d weight = out.covariance.inverse();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    double count = 0;
    for (const Eigen::Vector3d& color : colors) {
      const Eigen::Vector3d off = color - out.mean;
      if (off.dot(weight * off) > kOutlier2) continue;
      sum += off;
      squares += off * off.transpose();
      ++count;
    }
    if (count == 0) break;
    const Eigen::Vector3d moved = sum / count;
    out.mean += moved;
    out.covariance = squares / count - moved * moved.transpose() + least;
  }
  return out;
}

template <class Call>
void for_cells_of_cluster(const ColorTable& table, const ColorCluster& cluster, const Call& call) {
  const int step = step_of(table), last = table.side() - 1;
  // Makes a single pixel reach its cell's neighbours: 1.5 levels of noise, or the width of a cell.
  const double min_variance = std::pow(std::max(1.5, 1.01 * step / kReach), 2);
  Ellipsoid all;
  if (cluster.spread) {
    all.covariance = min_variance * Eigen::Matrix3d::Identity();
    for (std::size_t i = 0; i < 3; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      all.mean[row] = cluster.spread->mean[i];
      for (std::size_t j = 0; j < 3; ++j)
        all.covariance(row, static_cast<Eigen::Index>(j)) += cluster.spread->covariance[i][j];
    }
  } else if (!cluster.pixels.empty()) {
    all = ellipsoid_of(cluster.pixels, min_variance);
    // A single pixel represents its whole cell.
    if (cluster.pixels.size() == 1) {
      const Cell cell = cell_of(table, {cluster.pixels[0].y, cluster.pixels[0].u, cluster.pixels[0].v});
      all.mean = Eigen::Vector3d(cell.y, cell.u, cell.v) * step + Eigen::Vector3d::Constant((step - 1) / 2.0);
    }
  } else {
    return;
  }
  const Eigen::Matrix3d weight = all.covariance.inverse();
  const auto side_of = [&](Eigen::Index channel, int sign) {
    const double level = all.mean[channel] + sign * kReach * std::sqrt(all.covariance(channel, channel));
    return static_cast<int>(std::clamp(level / step, 0.0, static_cast<double>(last)));
  };
  const CellBox box{{side_of(0, -1), side_of(1, -1), side_of(2, -1)},
                    {side_of(0, 1), side_of(1, 1), side_of(2, 1)}};
  for_cells(table, box, [&](std::size_t place, const Cell& cell) {
    const Eigen::Vector3d off = Eigen::Vector3d(cell.y, cell.u, cell.v) * step +
                                Eigen::Vector3d::Constant((step - 1) / 2.0) - all.mean;
    if (off.dot(weight * off) <= kReach * kReach) call(place);
  });
}

struct ClusterCells {
  std::vector<std::size_t> added, left_clear;
};
ClusterCells cells_of(const ColorTable& table, const AddClusterEdit& edit) {
  ClusterCells out;
  bool all_stay = true;
  for_cells_of_cluster(table, edit.cluster, [&](std::size_t place) {
    const bool is_clear = table.labels[place] == label::kClear;
    const bool stays = edit.stays_clear && edit.stays_clear(table.color_of(place));
    all_stay = all_stay && stays;
    if (is_clear && stays) {
      out.left_clear.push_back(place);
    } else if (is_clear || edit.over == Over::kAny) {
      out.added.push_back(place);
    }
  });
  if (all_stay) {
    std::vector<std::size_t> all;
    std::merge(out.added.begin(), out.added.end(), out.left_clear.begin(), out.left_clear.end(),
               std::back_inserter(all));
    out = {std::move(all), {}};
  }
  return out;
}

void apply(const AddClusterEdit& edit, ColorTable& table, Brush& brush) {
  for (const std::size_t place : cells_of(table, edit).added) brush.set(place, edit.label);
}

void apply(const RemoveClusterEdit& edit, ColorTable& table, Brush& brush) {
  for_cells_of_cluster(table, edit.cluster, [&](std::size_t place) {
    if (!edit.only || table.labels[place] == *edit.only) brush.set(place, label::kClear);
  });
}

// ---- whole tables

void set_all(const ColorTable& all, ColorTable& table, Brush& brush) {
  for (std::size_t place = 0; place < table.labels.size(); ++place) brush.set(place, all.labels[place]);
}

void apply(const WidenMarginsEdit& edit, ColorTable& table, Brush& brush) {
  const Lut lut(table);  // for the typical chromaticities of its labels
  ColorTable widened = table;
  // The carpet has priority, because the colours typical of a label are only a guess here, unlike the colours
  // of dots in an image.
  const SurfaceReach carpet = reach_of(*edit.surfaces, SurfaceKind::kCarpet, edit.range);
  clear_surfaces(widened, *edit.surfaces, edit.range, [&](Label label, Yuv color) {
    if (carpet(color)) return false;
    const Rgb rgb = to_rgb(color);
    const double sum = std::max(1, rgb.r + rgb.g + rgb.b);
    const std::array<double, 3>& mean = lut.chromaticity_mean(label);
    return std::hypot(rgb.r / sum - mean[0], rgb.g / sum - mean[1], rgb.b / sum - mean[2]) <=
           lut.chromaticity_spread(label);
  });
  // Keeps the labels' chromaticities as prints. Otherwise they would shift, because surfaces take cells from
  // only one side of a label.
  const auto unit = [](double value) {
    return static_cast<std::uint16_t>(std::lround(PrintColor::kUnit * value));
  };
  std::array<bool, label::kMaxCount> has_cells{};
  for (const Label label : table.labels) has_cells[label] = true;
  for (std::size_t i = 1; i < label::kMaxCount; ++i) {
    const auto label = static_cast<Label>(i);
    if (table.prints[i] || !has_cells[i] || is_surface_label(label)) continue;
    const auto& mean = lut.chromaticity_mean(label);
    table.prints[i] =
        PrintColor{{unit(mean[0]), unit(mean[1]), unit(mean[2])}, unit(lut.chromaticity_spread(label))};
  }
  set_all(widened, table, brush);
}

void apply(const SetTableEdit& edit, ColorTable& table, Brush& brush) {
  if (edit.table.bits != table.bits) {
    throw SettingsError(
        fmt::format("a table of {} bits per channel cannot replace one of {}", edit.table.bits, table.bits));
  }
  set_all(edit.table, table, brush);
}

std::string cells_text(int cells) {
  return fmt::format("{} cell{}", cells, cells == 1 ? "" : "s");
}

struct WhatItDid {
  const LabelSet& labels;

  std::string operator()(const PaintEdit& edit) const { return "painted " + labels.name(edit.label); }
  std::string operator()(const EraseEdit& edit) const { return "erased" + named(edit.only); }
  std::string operator()(const FillEdit& edit) const { return "filled with " + labels.name(edit.label); }
  std::string operator()(const GrowEdit& edit) const {
    return fmt::format("grew {} by {}", labels.name(edit.label), cells_text(edit.cells));
  }
  std::string operator()(const ShrinkEdit& edit) const {
    return fmt::format("shrank {} by {}", labels.name(edit.label), cells_text(edit.cells));
  }
  std::string operator()(const SmoothEdit& edit) const { return "smoothed " + labels.name(edit.label); }
  std::string operator()(const ReplaceEdit& edit) const {
    return fmt::format("replaced {} with {}", labels.name(edit.from), labels.name(edit.to));
  }
  std::string operator()(const RemoveEdit& edit) const { return "removed " + labels.name(edit.label); }
  std::string operator()(const AddClusterEdit& edit) const {
    return "added colours to " + labels.name(edit.label);
  }
  std::string operator()(const RemoveClusterEdit& edit) const {
    return edit.only ? "removed colours from " + labels.name(*edit.only) : "cleared colours";
  }
  std::string operator()(const WidenMarginsEdit&) const { return "widened the margins to carpet and floor"; }
  std::string operator()(const SetTableEdit& edit) const { return edit.what; }

  std::string named(std::optional<Label> label) const { return label ? ' ' + labels.name(*label) : ""; }
};

}  // namespace

std::string what_it_did(const TableEdit& edit, const LabelSet& labels) {
  return std::visit(WhatItDid{labels}, edit);
}

std::vector<CellRun> apply_edit(ColorTable& table, const TableEdit& edit) {
  Brush brush(table);
  std::visit([&](const auto& each) { apply(each, table, brush); }, edit);
  std::vector<CellRun> changed = brush.take();
  if (const auto* whole = std::get_if<SetTableEdit>(&edit)) {
    table.prints = whole->table.prints;
  } else {
    // The cells that a label gets describe its colours better than its print.
    for (const CellRun& run : changed) table.prints[run.after].reset();
  }
  return changed;
}

std::size_t cells_left_clear(const ColorTable& table, const AddClusterEdit& edit) {
  return cells_of(table, edit).left_clear.size();
}

std::vector<CellRun> difference(const ColorTable& from, const ColorTable& to) {
  ColorTable changed = from;
  return apply_edit(changed, SetTableEdit{to, ""});
}

// ---- statistics

TableStatistics table_statistics(const ColorTable& table, std::size_t max_places) {
  TableStatistics out;
  for (const Label label : table.labels) ++out.cells[label];

  const auto is_color = [](Label label) {
    return label != label::kClear && label != label::kField && label != label::kWhite &&
           label != label::kBlack;
  };
  std::array<std::array<TableConflict, label::kMaxCount>, label::kMaxCount> pairs{};
  const int last = table.side() - 1;
  const CellBox whole{{0, 0, 0}, {last, last, last}};
  const std::size_t v_stride = std::size_t{1} << table.bits, u_stride = v_stride << table.bits;
  for_cells(table, whole, [&](std::size_t place, const Cell& cell) {
    const Label here = table.labels[place];
    if (!is_color(here)) return;
    std::uint32_t others = 0;
    const auto look_at = [&](bool inside, std::size_t neighbour) {
      if (!inside || table.labels[neighbour] == here || !is_color(table.labels[neighbour])) return;
      others |= std::uint32_t{1} << table.labels[neighbour];
    };
    look_at(cell.y > 0, place - 1);
    look_at(cell.y < last, place + 1);
    look_at(cell.v > 0, place - v_stride);
    look_at(cell.v < last, place + v_stride);
    look_at(cell.u > 0, place - u_stride);
    look_at(cell.u < last, place + u_stride);
    for (Label other = 0; others != 0; ++other, others >>= 1) {
      if ((others & 1) == 0) continue;
      TableConflict& pair = pairs[std::min(here, other)][std::max(here, other)];
      ++pair.cells;
      if (here < other && pair.places.size() < max_places) pair.places.push_back(table.color_of(place));
    }
  });
  for (std::size_t a = 0; a < pairs.size(); ++a) {
    for (std::size_t b = a + 1; b < pairs.size(); ++b) {
      if (pairs[a][b].cells == 0) continue;
      pairs[a][b].a = static_cast<Label>(a);
      pairs[a][b].b = static_cast<Label>(b);
      out.conflicts.push_back(std::move(pairs[a][b]));
    }
  }
  std::stable_sort(out.conflicts.begin(), out.conflicts.end(),
                   [](const auto& x, const auto& y) { return x.cells > y.cells; });
  return out;
}

}  // namespace sslv
