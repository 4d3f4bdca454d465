// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "vision/detections.h"
#include "vision/regions.h"

#include <string>

namespace sslv {

/// {"robots": [...], "balls": [...]} as in docs/openapi.json: millimetres, radians, pixels of the camera's
/// image.
Json detections_json(const RobotList& robots, const BallList& balls);

/// Things that resemble robots, nearest first: [{"pixel_x", "pixel_y", "radius", "text"}], pixels of the
/// camera's image.
Json misses_json(const RobotList& robots);

/// An unchecked line of a truth file from the detections in an image of this size: like detections_json(),
/// but without confidence and area, with the "number" of each mark, "by": "detector", and "checked": false.
Json truth_draft_json(const std::string& name, int width_px, int height_px, const RobotList& robots,
                      const BallList& balls);

/// The largest regions, as PreviewRegions in docs/openapi.json.
Json regions_json(const RegionList& regions, const LabelSet& labels);

}  // namespace sslv
