// SPDX-License-Identifier: Apache-2.0
#include "vision/sample_planes.h"

namespace sslv {

SamplePlanes sample_planes(PixelFormat format) {
  SamplePlanes out;
  if (is_yuv422(format)) {
    const int luma = format == PixelFormat::kUyvy ? 1 : 0, chroma = 1 - luma;
    out.yuv = true;
    out.groups[0].push_back({0, 0, 1, 1, 2, 1, {luma}, 0, 1});
    out.groups[1].push_back({0, 0, 2, 1, 4, 2, {chroma, chroma + 2}, 0.5F, 2});
  } else if (format == PixelFormat::kRgb24) {
    out.groups[0].push_back({0, 0, 1, 1, 3, 3, {0, 1, 2}, 0, 1});
  } else if (format == PixelFormat::kBgr24) {
    out.groups[0].push_back({0, 0, 1, 1, 3, 3, {2, 1, 0}, 0, 1});
  } else if (is_bayer(format)) {
    const int red_x = format == PixelFormat::kBayerGr8 || format == PixelFormat::kBayerBg8 ? 1 : 0;
    const int red_y = format == PixelFormat::kBayerGb8 || format == PixelFormat::kBayerBg8 ? 1 : 0;
    const auto one = [](int x, int y) { return SampleGrid{x, y, 2, 2, 2, 1, {x}, 0, 1}; };
    out.groups[0].push_back(one(red_x, red_y));
    out.groups[1].push_back(one(1 - red_x, red_y));
    out.groups[1].push_back(one(red_x, 1 - red_y));
    out.groups[2].push_back(one(1 - red_x, 1 - red_y));
  }
  return out;
}

std::array<double, 3> rgb_of_yuv_contrast(const std::array<double, 3>& c) {
  // BT.601 full range, as in image/color.h.
  return {c[0] + 1.402 * c[2], c[0] - 0.344136 * c[1] - 0.714136 * c[2], c[0] + 1.772 * c[1]};
}

std::array<double, 3> rgb_of_yuv_color(const std::array<double, 3>& c) {
  return rgb_of_yuv_contrast({c[0], c[1] - 128, c[2] - 128});
}

KernelPatch kernel_patch(const PlanePatch& p) {
  const auto f = [](double value) { return static_cast<float>(value); };
  return {f(p.xu), f(p.xv),  f(p.xuu), f(p.xuv), f(p.xvv),       f(p.yu),
          f(p.yv), f(p.yuu), f(p.yuv), f(p.yvv), f(p.pixel.x()), f(p.pixel.y())};
}

}  // namespace sslv
