// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

namespace sslv::test {

/// The only limit on waiting for what should happen: no busy machine is that slow.
inline constexpr std::chrono::seconds kPatience{300};

}  // namespace sslv::test
