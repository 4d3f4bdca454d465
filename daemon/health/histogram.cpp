// SPDX-License-Identifier: Apache-2.0
#include "health/histogram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sslv {
namespace {

constexpr std::size_t kBinsPerDecade = 12, kBins = 7 * kBinsPerDecade;

double edge_us(std::size_t bin) {
  return std::pow(10.0, static_cast<double>(bin) / static_cast<double>(kBinsPerDecade));
}

std::array<double, kBins + 1> all_edges_us() {
  std::array<double, kBins + 1> edges{};
  for (std::size_t i = 0; i < edges.size(); ++i) edges[i] = edge_us(i);
  return edges;
}

}  // namespace

Histogram make_histogram(std::span<const std::int64_t> durations_ns) {
  if (durations_ns.empty()) return {};
  static const std::array<double, kBins + 1> kEdges_us = all_edges_us();
  std::array<std::uint32_t, kBins> counts{};
  std::size_t first = kBins, last = 0;
  for (const std::int64_t duration_ns : durations_ns) {
    const double us = static_cast<double>(duration_ns) * 1e-3;
    // Searches only the inner edges, so durations out of range fall into the first or last bin.
    const auto above = std::upper_bound(kEdges_us.begin() + 1, kEdges_us.end() - 1, us);
    const auto bin = static_cast<std::size_t>(above - kEdges_us.begin()) - 1;
    ++counts[bin];
    first = std::min(first, bin);
    last = std::max(last, bin);
  }
  Histogram out;
  out.edges_us.assign(kEdges_us.begin() + static_cast<std::ptrdiff_t>(first),
                      kEdges_us.begin() + static_cast<std::ptrdiff_t>(last) + 2);
  out.counts.assign(counts.begin() + static_cast<std::ptrdiff_t>(first),
                    counts.begin() + static_cast<std::ptrdiff_t>(last) + 1);
  return out;
}

}  // namespace sslv
