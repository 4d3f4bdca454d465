// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/frame_info.h"

#include <algorithm>

namespace sslv {

/// When an image's rows saw what they show. Those of a rolling shutter come one after the other, evenly; the
/// frame's time is that of the middle one. By default all rows are exposed at once.
class RowTimes {
 public:
  RowTimes() = default;
  /// `read_out_s`: from the first row of the whole image to its last. `height_px` is this image's.
  RowTimes(double read_out_s, const WholePicture& whole, int height_px)
      : s_per_row_(read_out_s / std::max(1, (whole.height > 0 ? whole.height : height_px) - 1)),
        middle_px_(((whole.height > 0 ? whole.height : height_px) - 1) / 2.0 - whole.y) {}

  bool rolls() const { return s_per_row_ > 0; }
  double s_per_row() const { return s_per_row_; }
  /// Of the row at y_px in this image, from the frame's time on. What is seen there and moves at v was
  /// v * delay_s elsewhere at the frame's time.
  double delay_s(double y_px) const { return (y_px - middle_px_) * s_per_row_; }

 private:
  double s_per_row_ = 0, middle_px_ = 0;
};

}  // namespace sslv
