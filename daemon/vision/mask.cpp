// SPDX-License-Identifier: Apache-2.0
#include "vision/mask.h"

#include "base/error.h"
#include "vision/field_view.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <fmt/format.h>

namespace sslv {
namespace {

using Interval = Mask::Interval;

constexpr int kMaxSide = 16'384;  // largest side of an image, see is_valid_size()
constexpr Interval kWholeRow{0, kMaxSide};

/// A place in a row where the number of polygons around a cell changes.
struct Edge {
  int x;
  bool exclude;
  int step;  // +1: inside from here on, -1: outside
};

/// Adds the edges of one polygon in the row of cells whose centres are at `centre_y`.
void add_edges(const MaskPolygon& polygon, double centre_y, int cell_px, bool exclude,
               std::vector<double>& crossings, std::vector<Edge>& edges) {
  crossings.clear();
  const auto& points = polygon.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [x0, y0] = points[i];
    const auto& [x1, y1] = points[(i + 1) % points.size()];
    if ((y0 <= centre_y) == (y1 <= centre_y)) continue;
    crossings.push_back(x0 + (centre_y - y0) / (y1 - y0) * (x1 - x0));
  }
  std::sort(crossings.begin(), crossings.end());
  int step = 1;
  for (const double x_px : crossings) {
    // The first cell whose centre is not left of the crossing.
    const double cell = std::ceil((x_px - (cell_px - 1) * 0.5) / cell_px);
    edges.push_back({static_cast<int>(std::clamp(cell, 0.0, double{kMaxSide})), exclude, step});
    step = -step;
  }
}

/// Adds the intervals that are in an include polygon (or anywhere if there is no include polygon) and not in
/// an exclude polygon.
void add_intervals(std::vector<Edge>& edges, bool include_all, std::vector<Interval>& intervals) {
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.x < b.x; });
  int included = include_all ? 1 : 0, excluded = 0, begin = 0;
  bool inside = include_all;
  for (std::size_t i = 0; i < edges.size();) {
    const int x = edges[i].x;
    for (; i < edges.size() && edges[i].x == x; ++i)
      (edges[i].exclude ? excluded : included) += edges[i].step;
    const bool now = included > 0 && excluded == 0;
    if (inside && !now && x > begin) {
      intervals.push_back({static_cast<std::uint16_t>(begin), static_cast<std::uint16_t>(x)});
    }
    if (!inside && now) begin = x;
    inside = now;
  }
  if (inside && begin < kMaxSide) intervals.push_back({static_cast<std::uint16_t>(begin), kMaxSide});
}

/// Intersects the intervals from `first` on with the row's band.
void limit_to(const FieldView& view, int row_px, int cell_px, std::size_t first,
              std::vector<Interval>& intervals) {
  const auto band_index = static_cast<std::size_t>(row_px / FieldView::kBandPx);
  if (band_index >= view.bands.size()) return;
  std::vector<Interval> band;
  for (const Interval& one : view.bands[band_index])
    band.push_back(
        {static_cast<std::uint16_t>(one.begin / cell_px), static_cast<std::uint16_t>(one.end / cell_px)});
  if (view.width_px < kMaxSide)
    band.push_back({static_cast<std::uint16_t>(view.width_px / cell_px), kMaxSide});
  const std::vector<Interval> whole(intervals.begin() + static_cast<std::ptrdiff_t>(first), intervals.end());
  intervals.resize(first);
  for (const Interval& a : whole) {
    for (const Interval& b : band) {
      const Interval both{std::max(a.begin, b.begin), std::min(a.end, b.end)};
      if (both.begin < both.end) intervals.push_back(both);
    }
  }
}

}  // namespace

void check_mask(const MaskSettings& mask, const std::string& path) {
  std::size_t points = 0;
  for (const auto* polygons : {&mask.include, &mask.exclude}) {
    for (const MaskPolygon& polygon : *polygons) points += polygon.points.size();
  }
  if (points <= MaskSettings::kMaxPoints) return;
  throw SettingsError(fmt::format("{}: {} points in all polygons are not allowed; expected at most {}", path,
                                  points, MaskSettings::kMaxPoints));
}

std::uint64_t Mask::next_id() {
  static std::atomic<std::uint64_t> made{0};
  return ++made;
}

Mask::Mask(const MaskSettings& settings) {
  add_rows(settings, nullptr);
}

Mask::Mask(const MaskSettings& settings, const FieldView& view) {
  add_rows(settings, &view);
}

void Mask::add_rows(const MaskSettings& settings, const FieldView* view) {
  if (settings.include.empty()) rest_.push_back(kWholeRow);

  double bottom_px = -1;
  for (const auto* polygons : {&settings.include, &settings.exclude}) {
    for (const MaskPolygon& polygon : *polygons) {
      for (const auto& point : polygon.points) bottom_px = std::max(bottom_px, point[1]);
    }
  }
  if (view) bottom_px = std::max(bottom_px, static_cast<double>(view->bands.size()) * FieldView::kBandPx - 1);
  const int rows_px = static_cast<int>(std::clamp(bottom_px + 1, 0.0, double{kMaxSide}));

  std::vector<double> crossings;
  std::vector<Edge> edges;
  for (const int cell_px : {1, 2}) {
    Rows& rows = rows_[cell_px == 1 ? 0 : 1];
    rows.begin.push_back(0);
    for (int y = 0; y * cell_px < rows_px; ++y) {
      const double centre_y = y * cell_px + (cell_px - 1) * 0.5;
      edges.clear();
      for (const MaskPolygon& polygon : settings.include)
        add_edges(polygon, centre_y, cell_px, false, crossings, edges);
      for (const MaskPolygon& polygon : settings.exclude)
        add_edges(polygon, centre_y, cell_px, true, crossings, edges);
      const std::size_t first = rows.intervals.size();
      add_intervals(edges, settings.include.empty(), rows.intervals);
      if (view) limit_to(*view, y * cell_px, cell_px, first, rows.intervals);
      rows.begin.push_back(static_cast<std::uint32_t>(rows.intervals.size()));
    }
  }
}

}  // namespace sslv
