// SPDX-License-Identifier: Apache-2.0
#pragma once

// Whether later stages may rely on what a stage's process sent of an image: they index by labels, places and
// counts, which a stage inside is trusted with. Robots, balls, times and tracks are validated as those of
// stages inside (pipeline/senseless.h), which refuses what is infinite, too; how sure a place is, those who
// use it look at (SightingsQueue, Gather). What is no number was refused when the bytes were decoded. `now`
// is the frame with all that was sent.

#include "geometry/limits.h"
#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <cstddef>
#include <type_traits>

namespace sslv::apart {

/// More than these are no frame's.
inline constexpr std::size_t kMaxRuns = 1'000'000, kMaxRegions = 1'000'000;

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
  return with_lists(2 * limits::kMaxRobots * sizeof(Robot));
}
constexpr std::size_t most_bytes(std::type_identity<BallList>) {
  return with_lists(limits::kMaxBalls * sizeof(Ball));
}
constexpr std::size_t most_bytes(std::type_identity<CameraSightings>) {
  return with_lists(limits::kMaxRobots * sizeof(RobotSighting) +
                    limits::kMaxFieldBalls * sizeof(BallSighting));
}
constexpr std::size_t most_bytes(std::type_identity<ArrivedSightings>) {
  return most_bytes(std::type_identity<CameraSightings>{});
}
constexpr std::size_t most_bytes(std::type_identity<Observations>) {
  return with_lists(limits::kMaxRobots * sizeof(RobotObservation) +
                    limits::kMaxFieldBalls * sizeof(BallObservation));
}
constexpr std::size_t most_bytes(std::type_identity<TrackedField>) {
  return with_lists(limits::kMaxRobots * sizeof(TrackedRobot) + limits::kMaxFieldBalls * sizeof(TrackedBall));
}

template <class T, class Frame>
bool is_sound(const T&, const Frame&) {
  return true;
}
bool is_sound(const LabelImage& part, const Frame& now);
bool is_sound(const RunList& part, const Frame& now);
bool is_sound(const RegionList& part, const Frame& now);

/// For a frame that goes on without what a stage should have written. What counts on stays.
void make_empty(Frame& frame, PartSet written);
void make_empty(FieldFrame& frame, PartSet written);

}  // namespace sslv::apart
