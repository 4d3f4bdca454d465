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

/// The lines of the log that say who wanted to change something (log::kAuditId). Every change has a line. Of
/// requests that were refused, or change nothing, the first of an address has one; those that follow are
/// counted and written in one line a minute, so that nobody fills a disk with refusals. May be used from any
/// thread.
class AuditLog {
 public:
  using Clock = std::function<double()>;  // steady, s
  static constexpr double kPeriod_s = 60;
  /// That are counted apart; an IPv6 network is one. The others are counted together.
  static constexpr std::size_t kMaxAddresses = 64;

  explicit AuditLog(Clock now_s = steady_s);
  AuditLog(const AuditLog&) = delete;
  AuditLog& operator=(const AuditLog&) = delete;
  ~AuditLog();  // writes what was counted

  /// A request that was answered with `status`. `target`: its address, as it came.
  void add(const std::string& address, std::string_view method, std::string_view target, int status);

  /// Writes what was counted more than a minute ago: to be called now and then.
  void write_due();

 private:
  /// What is not written yet of an address, or of those that are not counted apart.
  struct Counted {
    double since_s = 0;
    std::map<int, std::uint64_t> by_status;
    std::string last;
  };
  using Lines = std::vector<std::string>;

  // With mutex_ held:
  Lines take_due(double now_s, double period_s);

  const Clock now_s_;
  std::mutex mutex_;  // guards what follows
  std::map<std::string, Counted> of_address_;
  Counted of_others_;
};

}  // namespace sslv
