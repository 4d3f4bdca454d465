// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/clock.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

/// Logs attempts to change something, with the client's address (log::kAuditId). Every change gets a line.
/// If requests are refused or change nothing, only the first request from an address gets a line; later
/// requests are counted and summarised in one line a minute, so that refusals cannot fill the disk.
/// Thread-safe.
class AuditLog {
 public:
  using Clock = std::function<double()>;  // steady, s
  static constexpr double kPeriod_s = 60;
  /// Addresses counted separately; an IPv6 network counts as one. All other addresses are counted together.
  static constexpr std::size_t kMaxAddresses = 64;

  explicit AuditLog(Clock now_s = steady_s);
  AuditLog(const AuditLog&) = delete;
  AuditLog& operator=(const AuditLog&) = delete;
  ~AuditLog();  // writes pending counts

  /// Records a request that was answered with `status`. `target`: the requested address as received.
  void add(const std::string& address, std::string_view method, std::string_view target, int status);

  /// Writes counts older than kPeriod_s. Call it periodically.
  void write_due();

 private:
  /// Pending counts of one address, or of all addresses that are not counted separately.
  struct Counted {
    double since_s = 0;
    std::map<int, std::uint64_t> by_status;
    std::string last;
  };
  using Lines = std::vector<std::string>;

  // With mutex_ held:
  Lines take_due(double now_s, double period_s);

  const Clock now_s_;
  std::mutex mutex_;  // guards the members below
  std::map<std::string, Counted> of_address_;
  Counted of_others_;
};

}  // namespace sslv
