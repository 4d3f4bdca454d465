// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sslv {

/// How often a duration was how long. Bins of 1 µs to 10 s, each a twelfth of a decade wide; what is shorter
/// or longer counts with the first or the last. Only the range where something is: counts[i] is of
/// edges_us[i] to below edges_us[i + 1]; both are empty without durations.
struct Histogram {
  std::vector<double> edges_us;
  std::vector<std::uint32_t> counts;
};

Histogram make_histogram(std::span<const std::int64_t> durations_ns);

}  // namespace sslv
