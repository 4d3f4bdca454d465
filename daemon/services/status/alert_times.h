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

/// Remembers since when alerts have been there. May be used from any thread.
class AlertTimes {
 public:
  /// Fills in `since_s`: of one that was not there the last time, now. How long one has been there is known
  /// by a steady clock, whatever becomes of the other.
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
