// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace sslv::bench {

/// Sum of `size` bytes, as fast as this CPU can read them: a lower bound for segmentation time.
std::uint64_t byte_sum(const std::uint8_t* data, std::size_t size);

}  // namespace sslv::bench
