// SPDX-License-Identifier: Apache-2.0
#include "vision/cut_off.h"

#include <algorithm>
#include <cmath>

namespace sslv {

bool is_cut_off(const Region& region, const ImageView& image, const Mask& mask) {
  const int cell_px = is_bayer(image.format) ? 2 : 1;
  const int columns = image.width / cell_px, rows = image.height / cell_px;
  const int left = region.left / cell_px, right = region.right / cell_px;
  const int top = region.top / cell_px, bottom = region.bottom / cell_px;
  // Checks an ellipse one cell larger than the region, because the mask may hide corners of the region's box
  // without touching the region.
  const double middle_x = (left + right) / 2.0, middle_y = (top + bottom) / 2.0;
  const double half_x = (right - left) / 2.0 + 1.5, half_y = (bottom - top) / 2.0 + 1.5;
  for (int y = std::max(0, top - 1); y <= std::min(rows - 1, bottom + 1); ++y) {
    const double up = (y - middle_y) / half_y, half = half_x * std::sqrt(1 - up * up);
    const int begin = std::max(0, static_cast<int>(std::ceil(middle_x - half)));
    const int end = std::min(columns, static_cast<int>(std::floor(middle_x + half)) + 1);
    if (begin >= end) continue;
    int shown_to = begin;
    for (const Mask::Interval& interval : mask.row(y, cell_px)) {
      if (interval.begin <= shown_to && interval.end > shown_to) shown_to = interval.end;
    }
    if (shown_to < end) return true;
  }
  return false;
}

}  // namespace sslv
