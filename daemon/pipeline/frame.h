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

/// Each slot of a camera's ring reuses one Frame: lists keep their capacity. Parts are identified by type.
struct Frame {
  FrameInfo info;
  Image image;
  LabelImage labels;
  RunList runs;
  RegionList regions;
  RobotList robots;
  BallList balls;
  OwnParts own_parts;                  // parts of stage libraries
  std::vector<std::int64_t> stage_ns;  // time each stage of the stack took, written by the pipeline
};

/// Configuration of one camera, replaced as a whole between frames.
struct CameraContext {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Lut> adapted_lut;  // table adapted to the current light
  std::shared_ptr<const Mask> mask;        // as the admin drew it
  std::shared_ptr<const PatternTable> patterns;
  std::shared_ptr<const Lut>
      accepted_lut{};  // source of `adapted_lut`; the same table if the light has not changed
  std::shared_ptr<const LabelSet> labels{};
  std::shared_ptr<const FieldView> field_view{};  // null: not calibrated, or the whole image is searched
  std::shared_ptr<const Mask> stage_mask{};       // `mask` and `field_view` combined; null: same as `mask`

  /// Mask for stages. Learning, margins and exposure use `mask` instead, because a calibration may be wrong.
  const Mask& looked_at() const { return stage_mask ? *stage_mask : *mask; }
};

}  // namespace sslv
