// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/detections.h"

#include <cstddef>
#include <span>

namespace sslv {

/// Writes what is wrong with a thing that resembles a robot, such as "3 of 5 dots are at their places", as
/// much as fits. Returns the length. Allocates nothing.
std::size_t miss_text(const RobotMiss& miss, std::span<char> text) noexcept;

}  // namespace sslv
