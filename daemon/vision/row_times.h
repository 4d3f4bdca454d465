// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/frame_info.h"

#include <algorithm>

namespace sslv {

/// Exposure times of an image's rows. A rolling shutter exposes the rows one after the other at equal
/// intervals; the frame's time is the exposure time of the middle row. By default, all rows are exposed
/// simultaneously.
class RowTimes {
 public:
  RowTimes() = default;
  /// `read_out_s`: time from the first to the last row of the whole image. `height_px`: height of this image,
  /// which may be a part of the whole image.
  RowTimes(double read_out_s, const WholePicture& whole, int height_px)
      : s_per_row_(read_out_s / std::max(1, (whole.height > 0 ? whole.height : height_px) - 1)),
        middle_px_(((whole.height > 0 ? whole.height : height_px) - 1) / 2.0 - whole.y) {}

  bool rolls() const { return s_per_row_ > 0; }
  double s_per_row() const { return s_per_row_; }
  /// Exposure time of the row at y_px of this image, relative to the frame's time. At the frame's time, an
  /// object seen there with velocity v was displaced by -v * delay_s.
  double delay_s(double y_px) const { return (y_px - middle_px_) * s_per_row_; }

 private:
  double s_per_row_ = 0, middle_px_ = 0;
};

}  // namespace sslv
