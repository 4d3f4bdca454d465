// SPDX-License-Identifier: Apache-2.0
#include "web/audit_log.h"

#include "base/log.h"
#include "base/plain_text.h"
#include "web/http.h"
#include "web/route.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Signing out does not count as a change: everybody may sign out, and it affects nobody else.
bool changes_something(std::string_view method, std::string_view target, int status) {
  return status < 400 && !(method == "DELETE" && target.starts_with("/api/session"));
}

std::string summary(std::string_view who, const std::map<int, std::uint64_t>& by_status, double seconds,
                    std::string_view last) {
  std::uint64_t all = 0;
  std::string figures;
  for (const auto& [status, times] : by_status) {
    all += times;
    figures += fmt::format("{}{} x {}", figures.empty() ? "" : ", ", status, times);
  }
  return fmt::format("audit: {}: {} more {} refused in {:.0f} s: {}; the last: {}", who, all,
                     all == 1 ? "request was" : "requests were", seconds, figures, last);
}

void write_lines(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) log::info("{}", line);
}

}  // namespace

AuditLog::AuditLog(Clock now_s) : now_s_(std::move(now_s)) {}

AuditLog::~AuditLog() {
  write_lines(take_due(now_s_(), 0));
}

void AuditLog::add(const std::string& address, std::string_view method, std::string_view target, int status) {
  constexpr std::size_t kMaxShown = 200;
  const std::string what = fmt::format(
      "{} {} {}", method, escaped_text(to_text(std::string(target.substr(0, kMaxShown)))), status);
  const std::string line = fmt::format("audit: {} {}", address, what);
  if (changes_something(method, target, status)) return write_lines({line});

  const double now_s = now_s_();
  Lines lines;
  {
    const std::lock_guard lock(mutex_);
    lines = take_due(now_s, kPeriod_s);
    const std::string network = network_of(address);
    const auto known = of_address_.find(network);
    if (known == of_address_.end() && of_address_.size() < kMaxAddresses) {
      of_address_[network].since_s = now_s;
      lines.push_back(line);
    } else {
      Counted& counted = known == of_address_.end() ? of_others_ : known->second;
      if (&counted == &of_others_ && counted.by_status.empty()) counted.since_s = now_s;
      ++counted.by_status[status];
      counted.last = what;
    }
  }
  write_lines(lines);
}

void AuditLog::write_due() {
  Lines lines;
  {
    const std::lock_guard lock(mutex_);
    lines = take_due(now_s_(), kPeriod_s);
  }
  write_lines(lines);
}

AuditLog::Lines AuditLog::take_due(double now_s, double period_s) {
  Lines lines;
  for (auto entry = of_address_.begin(); entry != of_address_.end();) {
    auto& [address, counted] = *entry;
    if (now_s - counted.since_s < period_s) {
      ++entry;
    } else if (counted.by_status.empty()) {
      entry = of_address_.erase(entry);  // the address's next request is logged again
    } else {
      lines.push_back(summary(address, counted.by_status, now_s - counted.since_s, counted.last));
      counted = {now_s, {}, {}};
      ++entry;
    }
  }
  if (!of_others_.by_status.empty() && now_s - of_others_.since_s >= period_s) {
    lines.push_back(
        summary("other addresses", of_others_.by_status, now_s - of_others_.since_s, of_others_.last));
    of_others_ = {};
  }
  return lines;
}

}  // namespace sslv
