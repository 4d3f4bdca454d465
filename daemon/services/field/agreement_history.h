// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "services/field/agreement_now.h"

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace sslv {

/// Calibrations are accurate to 1 to 2 mm: above kDriftMm, one of the two cameras has moved. The alert stays
/// until the difference is below kAgreeMm, so that it does not flicker near the limit.
constexpr double kDriftMm = 5, kAgreeMm = 4;

/// History of the agreement of each pair of cameras: their difference once a minute, and the time since which
/// it is too large.
class AgreementHistory {
 public:
  struct Minute {
    double t_s;  // Unix time
    double off_mm;
  };
  struct Pair {
    std::deque<Minute> minutes;
    double t_s = 0, off_mm = 0;       // time and value of the newest difference
    std::optional<double> since_s;    // when off_mm rose above kDriftMm; none once it is below kAgreeMm
    std::optional<double> before_mm;  // off_mm before since_s, while the cameras agreed
  };

  /// Call this about once a second, with the current pairs.
  void add(const std::vector<CameraPairNow>& pairs, double now_s);
  /// History of two cameras, in any order; null if they were never compared.
  const Pair* of(int camera, int other) const;
  /// The array `trends` of FieldAgreement in docs/openapi.json.
  Json to_json() const;

 private:
  std::map<std::pair<int, int>, Pair> pairs_;  // the smaller id first
};

}  // namespace sslv
