// SPDX-License-Identifier: Apache-2.0
#pragma once

// Validates the results that a stage's process sent for an image. Labels, positions and counts must be valid
// because later stages use them as indices; for stages inside the service, they are not validated. Robots,
// balls, times and tracks are validated as for stages inside the service (pipeline/validate.h), which also
// refuses infinite numbers; NaN was refused when the bytes were decoded. Uncertainties are checked where they
// are used (SightingsQueue, Gather). `now` is the frame with all parts that were sent.

#include "geometry/limits.h"
#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <cstddef>
#include <type_traits>

namespace sslv::sandbox {

/// Limits per frame.
inline constexpr std::size_t kMaxRuns = 1'000'000, kMaxRegions = 1'000'000;

/// Limit of a library's own part, encoded.
inline constexpr std::size_t kMaxOwnPartBytes = std::size_t{8} << 20;

/// The maximum encoded size of a part with lists of `bytes` bytes. Parts without lists are far smaller.
constexpr std::size_t with_lists(std::size_t bytes) {
  return bytes + (std::size_t{64} << 10);
}
template <class T>
constexpr std::size_t max_bytes(std::type_identity<T>) {
  return with_lists(0);
}
/// Limited only by the space for all parts, because is_valid() checks all pixels in one pass.
constexpr std::size_t max_bytes(std::type_identity<LabelImage>) {
  return with_lists(std::size_t{1} << 30);
}
constexpr std::size_t max_bytes(std::type_identity<RunList>) {
  return with_lists(kMaxRuns * sizeof(Run));
}
constexpr std::size_t max_bytes(std::type_identity<RegionList>) {
  return with_lists(kMaxRegions * sizeof(Region));
}
constexpr std::size_t max_bytes(std::type_identity<RobotList>) {
  return with_lists(2 * limits::kMaxRobots * sizeof(Robot) + limits::kMaxMisses * sizeof(RobotMiss));
}
constexpr std::size_t max_bytes(std::type_identity<BallList>) {
  return with_lists(limits::kMaxBalls * sizeof(Ball));
}
constexpr std::size_t max_bytes(std::type_identity<CameraSightings>) {
  return with_lists(limits::kMaxRobots * sizeof(RobotSighting) +
                    limits::kMaxFieldBalls * sizeof(BallSighting));
}
constexpr std::size_t max_bytes(std::type_identity<ArrivedSightings>) {
  return max_bytes(std::type_identity<CameraSightings>{});
}
constexpr std::size_t max_bytes(std::type_identity<Observations>) {
  return with_lists(limits::kMaxRobots * sizeof(RobotObservation) +
                    limits::kMaxFieldBalls * sizeof(BallObservation));
}
constexpr std::size_t max_bytes(std::type_identity<TrackedField>) {
  return with_lists(limits::kMaxRobots * sizeof(TrackedRobot) + limits::kMaxFieldBalls * sizeof(TrackedBall));
}

template <class T, class Frame>
bool is_valid(const T&, const Frame&) {
  return true;
}
bool is_valid(const LabelImage& part, const Frame& now);
bool is_valid(const RunList& part, const Frame& now);
bool is_valid(const RegionList& part, const Frame& now);

/// Empties the written parts of a frame that continues without the stage's results. Parts that accumulate
/// keep their contents.
void make_empty(Frame& frame, PartSet written);
void make_empty(FieldFrame& frame, PartSet written);

}  // namespace sslv::sandbox
