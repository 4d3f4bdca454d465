// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/params.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace sslv {

/// A closed polygon in pixels of the image; pixel centres are at whole numbers. It may cross itself: its
/// inside is defined by the even-odd rule.
struct MaskPolygon {
  static constexpr std::size_t kMaxPoints = 200;
  std::vector<std::array<double, 2>> points;
  static constexpr auto fields() {
    return std::tuple{
        point_list("points", &MaskPolygon::points, 3, kMaxPoints, -16384, 32768, "px", "corners in order")};
  }
};

/// The part of the image that is searched.
struct MaskSettings {
  /// kMaxPolygons: maximum number of polygons in `include`, and in `exclude`. kMaxPoints: maximum number of
  /// points in all polygons together. Every point increases the memory of the mask's rows.
  static constexpr std::size_t kMaxPolygons = 32, kMaxPoints = 1000;
  std::vector<MaskPolygon> include, exclude;
  std::optional<double> beyond_boundary = 0;
  static constexpr auto fields() {
    return std::tuple{
        number("beyond_boundary", &MaskSettings::beyond_boundary, 0.0, 100'000.0, "mm",
               "how far beyond the field's boundary a calibrated camera still searches; empty (null): the "
               "whole image"),
        list("include", &MaskSettings::include, "only these polygons are searched; none: everything",
             kMaxPolygons),
        list("exclude", &MaskSettings::exclude, "these polygons are not searched", kMaxPolygons),
    };
  }
};

/// Throws SettingsError, its message starting with `path`, if the polygons have too many points together.
void check_mask(const MaskSettings& mask, const std::string& path);

struct FieldView;

/// The visible intervals of each row, from the polygons of MaskSettings and a camera's view of its field. For
/// images of any size. Immutable.
class Mask {
 public:
  /// Cells [begin, end) of a row.
  struct Interval {
    std::uint16_t begin, end;
    bool operator==(const Interval&) const = default;
  };

  /// Everything is visible.
  Mask() : Mask(MaskSettings{}) {}
  /// Only what the settings leave visible.
  explicit Mask(const MaskSettings& settings);
  /// Additionally limits the visible part to `view` (vision/field_view.h).
  Mask(const MaskSettings& settings, const FieldView& view);

  /// The visible cells of row `y`: ascending, disjoint, none empty, to be clipped by the caller at the
  /// image's right edge. cell_px is 1, or 2 for the quads of a Bayer image. A cell is visible if its centre
  /// is visible.
  std::span<const Interval> row(int y, int cell_px) const {
    const Rows& rows = rows_[cell_px == 1 ? 0 : 1];
    const auto i = static_cast<std::size_t>(y);
    if (i + 1 >= rows.begin.size()) return rest_;
    return std::span(rows.intervals).subspan(rows.begin[i], rows.begin[i + 1] - rows.begin[i]);
  }

  /// Whether the pixel at this position is visible. For a position left of or above the image, the nearest
  /// pixel in the image counts.
  bool shows(double x, double y) const {
    const auto pixel = [](double at) { return static_cast<int>(std::lround(std::clamp(at, 0.0, kMaxPx))); };
    const int column = pixel(x);
    return std::ranges::any_of(row(pixel(y), 1), [column](const Interval& interval) {
      return column >= interval.begin && column < interval.end;
    });
  }

  /// Unique for every mask made in this process, except that copies share it.
  std::uint64_t id() const { return id_; }
  /// All members, for a copy in another process (pipeline/part_codec.h).
  template <class Self>
  static auto stored(Self& self) {
    return std::tie(self.rows_, self.rest_, self.id_);
  }

 private:
  static constexpr double kMaxPx = 16'383;
  static std::uint64_t next_id();
  void add_rows(const MaskSettings& settings, const FieldView* view);
  struct Rows {
    std::vector<Interval> intervals;
    std::vector<std::uint32_t> begin;  // row y has the intervals begin[y] .. begin[y + 1]
  };
  std::array<Rows, 2> rows_;    // rows of pixels; rows of Bayer quads
  std::vector<Interval> rest_;  // intervals of every row below rows_
  std::uint64_t id_ = next_id();
};

}  // namespace sslv
