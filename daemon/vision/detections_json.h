// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "vision/detections.h"
#include "vision/regions.h"

namespace sslv {

/// {"robots": [...], "balls": [...]} as docs/openapi.json says: millimetres, radians, pixels of the camera's
/// image.
Json detections_json(const RobotList& robots, const BallList& balls);

/// The largest regions as docs/openapi.json's PreviewRegions has them.
Json regions_json(const RegionList& regions, const LabelSet& labels);

}  // namespace sslv
