// SPDX-License-Identifier: Apache-2.0
#pragma once

// The schema of the field: everything known about it after one image of one camera. A new kind of data is one
// member here and one line in field_stage.h.

#include "pipeline/own_parts.h"
#include "tracking/camera_agreement.h"
#include "tracking/gather.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <cstdint>
#include <vector>

namespace sslv {

/// A single FieldFrame is reused for every image: lists keep their capacity, and learnt values are kept.
/// Parts are identified by their type.
struct FieldFrame {
  ArrivedSightings arrived;
  CameraSightings sightings;
  LeftOut left_out;
  ImageTime time;
  Observations observations;
  CameraAgreement agreement;
  TrackedField tracked;
  OwnParts own_parts;                  // parts of stage libraries
  std::vector<std::int64_t> stage_ns;  // time each stage of the stack took, written by the pipeline
};

}  // namespace sslv
