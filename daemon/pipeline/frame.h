// SPDX-License-Identifier: Apache-2.0
#pragma once

// The schema: everything known about one captured frame, and everything that is constant while it is
// processed. A new kind of data is one member here and one line in camera_stage.h.

#include "geometry/scene.h"
#include "image/frame_info.h"
#include "image/image.h"
#include "pipeline/own_parts.h"
#include "vision/detections.h"
#include "vision/lut.h"
#include "vision/mask.h"
#include "vision/patterns.h"
#include "vision/regions.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace sslv {

/// One per slot of a camera's ring, reused: lists keep their capacity. Parts are told apart by their type.
struct Frame {
  FrameInfo info;
  Image image;
  LabelImage labels;
  RunList runs;
  RegionList regions;
  RobotList robots;
  BallList balls;
  OwnParts own_parts;                  // what stage libraries brought
  std::vector<std::int64_t> stage_ns;  // time each stage of the stack took, written by the pipeline
};

/// What the admin has set up for one camera, swapped as a whole between frames.
struct CameraContext {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Lut> adapted_lut;  // for the current light
  std::shared_ptr<const Mask> mask;        // as the admin drew it
  std::shared_ptr<const PatternTable> patterns;
  std::shared_ptr<const Lut>
      accepted_lut{};  // what `adapted_lut` was made from; the same when the light has not changed
  std::shared_ptr<const LabelSet> labels{};
  std::shared_ptr<const FieldView> field_view{};  // null: not calibrated, or all of the image is looked at
  std::shared_ptr<const Mask> stage_mask{};       // `mask` and `field_view`; null: `mask`

  /// What stages look at. Learning, margins and exposure look at all that the admin leaves: a calibration
  /// may be wrong.
  const Mask& looked_at() const { return stage_mask ? *stage_mask : *mask; }
};

}  // namespace sslv
