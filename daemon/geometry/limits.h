// SPDX-License-Identifier: Apache-2.0
#pragma once

// Limits of what comes from outside: packets of other programs, and results of stages of libraries. The table
// in docs/protocol.md has them too; pipeline/senseless.h and net/vision_message.h enforce them.

#include <cstddef>

namespace sslv::limits {

/// Of a robot's pattern, and of a camera.
inline constexpr int kMaxId = 255;
/// Of a place (mm, px), a speed (mm/s): a kilometre.
inline constexpr double kMaxPlaceMm = 1e6;
/// How high a robot's pattern may be, and how much higher a camera hangs at least.
inline constexpr double kMaxRobotHeightMm = 1000, kMinAboveRobotMm = 150;
/// How high a camera hangs, and how far from the field's centre it is at most.
inline constexpr double kMinCameraMm = 300, kMaxCameraMm = 100'000;

/// Of a packet's times (Unix s, or since its computer started): some thousand years.
inline constexpr double kMaxTime_s = 1e11;

/// In an image, a packet and the tracks: twice as many as play.
inline constexpr std::size_t kMaxRobots = 64;
/// In an image's detections. With its robots they fit into a datagram.
inline constexpr std::size_t kMaxBalls = 1024;
/// Of an image in the field's stack, and in the tracks.
inline constexpr std::size_t kMaxFieldBalls = 64;
/// Tracked together, and sent by one other computer.
inline constexpr std::size_t kMaxCameras = 32;
/// Other computers that the settings name, and as many others that are listed. The latter together have
/// kMaxUnnamedCameras.
inline constexpr std::size_t kMaxComputers = 16, kMaxUnnamedCameras = 64;

}  // namespace sslv::limits
