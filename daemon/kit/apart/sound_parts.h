// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether what a stage's process sent is what later stages of the service may rely on: they index by labels,
// ids and counts, which a stage that runs inside is trusted with. Numbers that are none were refused when the
// bytes were read. `now` is the frame with all that was sent, `before` what was in its place.

#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

namespace sslv::apart {

/// More than these are no frame's.
inline constexpr std::size_t kMaxRobots = 4096, kMaxBalls = 4096, kMaxRuns = 1'000'000,
                             kMaxRegions = 1'000'000;

bool is_sound(const FrameInfo& part, const Frame& now, const Frame& before);
bool is_sound(const LabelImage& part, const Frame& now, const Frame& before);
bool is_sound(const RunList& part, const Frame& now, const Frame& before);
bool is_sound(const RegionList& part, const Frame& now, const Frame& before);
bool is_sound(const RobotList& part, const Frame& now, const Frame& before);
bool is_sound(const BallList& part, const Frame& now, const Frame& before);

bool is_sound(const ArrivedSightings& part, const FieldFrame& now, const FieldFrame& before);
bool is_sound(const CameraSightings& part, const FieldFrame& now, const FieldFrame& before);
bool is_sound(const LeftOut& part, const FieldFrame& now, const FieldFrame& before);
bool is_sound(const ImageTime& part, const FieldFrame& now, const FieldFrame& before);
bool is_sound(const Observations& part, const FieldFrame& now, const FieldFrame& before);
bool is_sound(const TrackedField& part, const FieldFrame& now, const FieldFrame& before);

/// For a frame that goes on without what a stage should have written. What counts on stays.
void make_empty(Frame& frame, PartSet written);
void make_empty(FieldFrame& frame, PartSet written);

}  // namespace sslv::apart
