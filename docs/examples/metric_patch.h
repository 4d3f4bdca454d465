// SPDX-License-Identifier: Apache-2.0
#pragma once

// record_patches and learned_balls extract patches with the same code, so that the network gets the same kind
// of input in a match as in training.

#include <array>
#include <cmath>

#include <Eigen/Core>
#include <image/pixel_at.h>
#include <kit/stages.h>

/// Pixels, row by row.
constexpr int kPatchSide = 12;
using Patch = std::array<sslv::Rgb, kPatchSide * kPatchSide>;

/// The square of side_mm around a point on the plane z = height: a ball has the same size in the patch
/// wherever it is in the image. Pixels outside the image are black.
inline Patch metric_patch(const sslv::ImageView& image, const sslv::CameraModel& camera, double x_mm,
                          double y_mm, double height_mm, double side_mm) {
  Patch out{};
  const double step_mm = side_mm / kPatchSide;
  const Eigen::Vector3d first(x_mm - (side_mm - step_mm) / 2, y_mm - (side_mm - step_mm) / 2, height_mm);
  for (int i = 0; i < kPatchSide * kPatchSide; ++i) {
    const Eigen::Vector3d place = first + step_mm * Eigen::Vector3d(i % kPatchSide, i / kPatchSide, 0);
    const auto pixel = camera.project(place);
    if (!pixel) continue;
    const double x = std::round(pixel->x()), y = std::round(pixel->y());
    if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
    out[static_cast<std::size_t>(i)] = sslv::rgb_at(image, static_cast<int>(x), static_cast<int>(y));
  }
  return out;
}
