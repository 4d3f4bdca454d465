// SPDX-License-Identifier: Apache-2.0
#include "services/status/alert_times.h"

#include <cmath>
#include <utility>

namespace sslv {

void AlertTimes::stamp(std::vector<Alert>& alerts, double now_s, double steady_s) {
  constexpr double kClockWasSet_s = 0.1;
  std::map<Key, Since> next;
  const std::lock_guard lock(mutex_);
  for (Alert& alert : alerts) {
    const Key key{alert.id, alert.camera, alert.about};
    const auto known = since_.find(key);
    Since since = known == since_.end() ? Since{now_s, steady_s} : known->second;
    // The same at every call unless the clock was set in between.
    const double by_steady_s = now_s - (steady_s - since.steady_s);
    if (std::abs(by_steady_s - since.unix_s) > kClockWasSet_s) since.unix_s = by_steady_s;
    alert.since_s = since.unix_s;
    next[key] = since;
  }
  since_ = std::move(next);
}

}  // namespace sslv
