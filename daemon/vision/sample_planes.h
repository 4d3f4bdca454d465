// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/plane_patch.h"
#include "image/image.h"
#include "vision/disc_kernel.h"

#include <array>

#include <boost/container/static_vector.hpp>

namespace sslv {

/// The three colour planes of a format and the positions of their samples. Grids of one group are read
/// together: both greens of a Bayer image are one plane. Images without colours have no groups.
struct SamplePlanes {
  std::array<boost::container::static_vector<SampleGrid, 2>, 3> groups;
  bool yuv = false;  // planes are Y, U, V and not red, green, blue
};
SamplePlanes sample_planes(PixelFormat format);

/// Red, green and blue of a colour in YUV, or of a difference between two colours in YUV; neither rounded nor
/// clamped.
std::array<double, 3> rgb_of_yuv_color(const std::array<double, 3>& yuv);
std::array<double, 3> rgb_of_yuv_contrast(const std::array<double, 3>& yuv);

KernelPatch kernel_patch(const PlanePatch& patch);

}  // namespace sslv
