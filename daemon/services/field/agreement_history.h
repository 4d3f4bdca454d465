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

/// Calibrations are good to a millimetre or two; farther apart, one of the cameras is no longer where it was.
/// Near the limit an alert would come and go.
constexpr double kDriftMm = 5, kAgreeMm = 4;

/// How the agreement of each two cameras went: a value for each minute, and since when they differ too much.
class AgreementHistory {
 public:
  struct Minute {
    double t_s;  // Unix time
    double off_mm;
  };
  struct Pair {
    std::deque<Minute> minutes;
    double t_s = 0, off_mm = 0;       // the newest
    std::optional<double> since_s;    // they differ too much: from more than kDriftMm to less than kAgreeMm
    std::optional<double> before_mm;  // what it was before that, where they agreed
  };

  /// To be called about once a second, with what was measured just now.
  void add(const std::vector<CameraPairNow>& pairs, double now_s);
  /// Null for two that were never compared. Whichever comes first.
  const Pair* of(int camera, int other) const;
  /// The array `trends` of docs/openapi.json's FieldAgreement.
  Json to_json() const;

 private:
  std::map<std::pair<int, int>, Pair> pairs_;  // the smaller number first
};

}  // namespace sslv
