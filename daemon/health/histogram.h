// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sslv {

/// Histogram of durations from 1 µs to 10 s, in bins a twelfth of a decade wide. Shorter and longer durations
/// count in the first and last bin. Empty bins at both ends are left out. counts[i] holds durations from
/// edges_us[i] to below edges_us[i + 1]. Both are empty without durations.
struct Histogram {
  std::vector<double> edges_us;
  std::vector<std::uint32_t> counts;
};

Histogram make_histogram(std::span<const std::int64_t> durations_ns);

}  // namespace sslv
