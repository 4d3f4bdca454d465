// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sslv {

/// A robot's pose on the plane of its top.
struct PatternPose {
  double x_mm, y_mm, angle_rad;
};

}  // namespace sslv
