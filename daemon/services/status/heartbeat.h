// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "services/service.h"

#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// Calls each_second() of all services once a second, on a thread of low priority, then makes the line that
/// the service manager shows. A call that hangs delays no other thread.
class Heartbeat {
 public:
  /// Starts at once. All must outlive this.
  Heartbeat(std::vector<Service*> services, std::function<std::string()> make_summary);

  /// Starts stopping without waiting; the destructor waits.
  void ask_to_stop() { thread_.request_stop(); }

  /// The newest line. Does not wait.
  std::string summary() const { return *summary_.load(); }

 private:
  void beat(const std::stop_token& stop) noexcept;

  const std::vector<Service*> services_;
  const std::function<std::string()> make_summary_;
  Snapshot<std::string> summary_;
  std::jthread thread_;  // last: stops before the members it uses are destroyed
};

}  // namespace sslv
