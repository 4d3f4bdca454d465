// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "geometry/camera_model.h"

namespace sslv::test {

/// Simulated clicks for calibrating this camera over Division B: six visible corners and crossings,
/// unordered, each up to 3 px off.
Json clicked_points(const CameraModel& camera);

/// Largest distance in mm, over this camera's part of the field, between a point on the plane z = height and
/// the point that `other` computes for its pixel. Infinite where `other` sees no floor.
double worst_error_mm(const CameraModel& camera, const CameraModel& other, double height_mm);

}  // namespace sslv::test
