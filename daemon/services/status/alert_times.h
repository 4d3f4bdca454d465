// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/health_report.h"

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace sslv {

/// Records the times at which active alerts began. Thread-safe.
class AlertTimes {
 public:
  /// Fills in `since_s`: the current time for an alert that was not active at the last call. Durations are
  /// measured on the steady clock, so that setting the system clock does not change them.
  void stamp(std::vector<Alert>& alerts, double now_s, double steady_s);

 private:
  using Key = std::tuple<std::string, std::optional<int>, std::string>;
  struct Since {
    double unix_s, steady_s;
  };
  std::mutex mutex_;
  std::map<Key, Since> since_;
};

}  // namespace sslv
