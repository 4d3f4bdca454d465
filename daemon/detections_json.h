// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "vision/detections.h"

namespace sslv {

/// {"robots": [...], "balls": [...]} as docs/openapi.json says: millimetres, radians, pixels of the camera's
/// picture.
Json detections_json(const RobotList& robots, const BallList& balls);

}  // namespace sslv
