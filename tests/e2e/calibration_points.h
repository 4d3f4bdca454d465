// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "geometry/camera_model.h"

namespace sslv::test {

/// What somebody clicks who calibrates this camera over Division B: six corners and crossings that it sees,
/// in no order, each up to 3 px off.
Json clicked_points(const CameraModel& camera);

/// Largest distance over this camera's part of the field, in mm, between a place on the plane z = height and
/// where `other` has it.
double worst_error_mm(const CameraModel& camera, const CameraModel& other, double height_mm);

}  // namespace sslv::test
