// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/service.h"

#include <functional>
#include <thread>
#include <vector>

namespace sslv {

/// Calls each_second() of all services once a second, in a thread of low priority, then `then`. What hangs
/// there delays nothing else.
class Heartbeat {
 public:
  /// Starts at once. All must outlive this.
  Heartbeat(std::vector<Service*> services, std::function<void()> then);

 private:
  void beat() noexcept;

  const std::vector<Service*> services_;
  const std::function<void()> then_;
  std::jthread thread_;  // last, so that it ends before what it uses
};

}  // namespace sslv
