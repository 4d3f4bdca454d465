// SPDX-License-Identifier: Apache-2.0
#pragma once

// Limits for input from outside: packets of other programs and results of stage libraries. docs/protocol.md
// also lists the limits; pipeline/validate.h and net/vision_message.h enforce them.

#include <cstddef>

namespace sslv::limits {

/// Largest id of a robot and of a camera.
inline constexpr int kMaxId = 255;
/// Largest coordinate (mm, px) and speed (mm/s): 1 km.
inline constexpr double kMaxPlaceMm = 1e6;
/// Largest height of a robot's pattern; smallest height of a camera above the pattern.
inline constexpr double kMaxRobotHeightMm = 1000, kMinAboveRobotMm = 150;
/// Smallest height of a camera above the floor; largest distance of a camera from the field's centre.
inline constexpr double kMinCameraMm = 300, kMaxCameraMm = 100'000;

/// Largest time in a packet (Unix s, or s since the sender's computer started): about 3000 years.
inline constexpr double kMaxTime_s = 1e11;

/// Robots in an image, in a packet and in the tracks: twice the number of robots that play.
inline constexpr std::size_t kMaxRobots = 64;
/// Things in an image that resemble robots.
inline constexpr std::size_t kMaxMisses = 8;
/// Balls in an image's detections. Robots and balls together fit into a datagram.
inline constexpr std::size_t kMaxBalls = 1024;
/// Balls of one image that the field's stack processes, and balls in the tracks.
inline constexpr std::size_t kMaxFieldBalls = 64;
/// Cameras tracked together, and cameras sent by one other computer.
inline constexpr std::size_t kMaxCameras = 32;
/// kMaxComputers: other computers named in the settings; also the limit for listed computers that are not
/// named. kMaxUnnamedCameras: cameras of all unnamed computers together.
inline constexpr std::size_t kMaxComputers = 16, kMaxUnnamedCameras = 64;

}  // namespace sslv::limits
