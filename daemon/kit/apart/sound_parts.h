// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether what a stage's process sent is what later stages of the service may rely on: they index by labels,
// ids and counts, which a stage that runs inside is trusted with. Numbers that are none were refused when the
// bytes were read. `now` is the frame with all that was sent, `before` what was in its place.

#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <cstddef>
#include <type_traits>

namespace sslv::apart {

/// More than these are no frame's.
inline constexpr std::size_t kMaxRobots = 4096, kMaxBalls = 4096, kMaxRuns = 1'000'000,
                             kMaxRegions = 1'000'000;

/// Of a library's own part, as bytes.
inline constexpr std::size_t kMaxOwnPartBytes = std::size_t{8} << 20;

/// The most bytes that such a part can have when it is sent. What holds no lists has far fewer.
constexpr std::size_t with_lists(std::size_t bytes) {
  return bytes + (std::size_t{64} << 10);
}
template <class T>
constexpr std::size_t most_bytes(std::type_identity<T>) {
  return with_lists(0);
}
/// Not more than the room for all; its pixels are looked at together.
constexpr std::size_t most_bytes(std::type_identity<LabelImage>) {
  return with_lists(std::size_t{1} << 30);
}
constexpr std::size_t most_bytes(std::type_identity<RunList>) {
  return with_lists(kMaxRuns * sizeof(Run));
}
constexpr std::size_t most_bytes(std::type_identity<RegionList>) {
  return with_lists(kMaxRegions * sizeof(Region));
}
constexpr std::size_t most_bytes(std::type_identity<RobotList>) {
  return with_lists(kMaxRobots * sizeof(Robot));
}
constexpr std::size_t most_bytes(std::type_identity<BallList>) {
  return with_lists(kMaxBalls * sizeof(Ball));
}
constexpr std::size_t most_bytes(std::type_identity<CameraSightings>) {
  return with_lists(kMaxRobots * sizeof(RobotSighting) + kMaxBalls * sizeof(BallSighting));
}
constexpr std::size_t most_bytes(std::type_identity<ArrivedSightings>) {
  return most_bytes(std::type_identity<CameraSightings>{});
}
constexpr std::size_t most_bytes(std::type_identity<Observations>) {
  return with_lists(kMaxRobots * sizeof(RobotObservation) + kMaxBalls * sizeof(BallObservation));
}
constexpr std::size_t most_bytes(std::type_identity<TrackedField>) {
  return with_lists(kMaxRobots * sizeof(TrackedRobot) + kMaxBalls * sizeof(TrackedBall));
}

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
