// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "image/image.h"
#include "vision/lut.h"

#include <cstdint>
#include <vector>

namespace sslv::bench {

/// The reference for segmentation: the classic three passes over a labelled image (Bruce, Balch, Veloso: Fast
/// and Inexpensive Color Image Segmentation for Interactive Robots, IROS 2000), without optimisation. Like
/// those in use, the table has 64 Ki entries: YUV 4, 6, 6 bits; RGB 5, 6, 5.
class ThreePasses {
 public:
  struct Run {
    std::int16_t x, y, width;
    Label label;
    std::int32_t parent;
  };
  struct Region {
    Label label;
    std::int32_t area;
    std::int16_t left, top, right, bottom;
    std::int64_t sum_x, sum_y;
    float x, y;
  };

  explicit ThreePasses(const Lut& lut);

  /// Regions by label, then by decreasing area. Bayer images are read in quads.
  const std::vector<Region>& process(const ImageView& image);

 private:
  void threshold(const ImageView& image);
  void find_runs();
  void connect();
  void extract();
  void sort();

  std::vector<Label> yuv_, rgb_;
  int width_ = 0, height_ = 0;
  std::vector<Label> map_;  // rows of width_ + 1: the last pixel ends every run
  std::vector<Run> runs_;
  std::vector<Region> regions_;
};

}  // namespace sslv::bench
