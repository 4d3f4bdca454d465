// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace sslv::test {

/// Timeout of all waits for expected events: no busy machine is that slow.
inline constexpr std::chrono::seconds kPatience{300};

}  // namespace sslv::test
