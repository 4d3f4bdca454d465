// SPDX-License-Identifier: Apache-2.0
#pragma once

// What may come from outside: packets of other programs, and what stages of libraries make of an image. All
// limits of both stand here, and in the table of docs/protocol.md; pipeline/senseless.h holds them.

#include <cstddef>

namespace sslv::limits {

/// Of a robot's pattern, and of a camera.
inline constexpr int kMaxId = 255;
/// Of a place (mm, px) and a speed (mm/s): a kilometre.
inline constexpr double kMaxPlaceMm = 1e6;
/// How high a robot's pattern may be, and how much higher a camera hangs at least.
inline constexpr double kMaxRobotHeightMm = 1000, kMinAboveRobotMm = 150;
/// How high a camera hangs, and how far from the field's centre it is at most.
inline constexpr double kMinCameraMm = 300, kMaxCameraMm = 100'000;

/// In an image, a packet and the tracks: twice as many as play.
inline constexpr std::size_t kMaxRobots = 64;
/// In an image's detections; with its robots they fit into a datagram.
inline constexpr std::size_t kMaxBalls = 1024;
/// Of an image in the field's stack, and in the tracks: the surest.
inline constexpr std::size_t kMaxFieldBalls = 64;
/// That are tracked together, and that one other computer may send.
inline constexpr std::size_t kMaxCameras = 32;
/// Other computers that are listed, and likewise those that the settings name. Together the former have
/// kMaxUnnamedCameras.
inline constexpr std::size_t kMaxComputers = 16, kMaxUnnamedCameras = 64;

}  // namespace sslv::limits
