// SPDX-License-Identifier: Apache-2.0
#include "base/log_ring.h"

#include <array>

namespace sslv::log {
namespace {

constexpr std::array<std::string_view, 4> kNames{"debug", "info", "warning", "error"};

}  // namespace

std::string_view name_of(Level level) {
  return kNames[static_cast<std::size_t>(level)];
}

std::optional<Level> level_named(std::string_view name) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == name) return static_cast<Level>(i);
  }
  return std::nullopt;
}

void LogRing::add(double time_s, Level level, std::string_view text) {
  std::string kept(text.substr(0, kLongestLine));
  if (text.size() > kLongestLine) kept += " ...";
  const std::lock_guard lock(mutex_);
  bytes_ += kept.size();
  lines_.push_back({++newest_, time_s, level, std::move(kept)});
  while (lines_.size() > kMaxLines || bytes_ > kMaxBytes) {
    bytes_ -= lines_.front().text.size();
    lines_.pop_front();
  }
}

LogRing::Lines LogRing::newer_than(std::uint64_t seen, Level least) const {
  const std::lock_guard lock(mutex_);
  if (seen > newest_) seen = 0;
  Lines out{{}, newest_};
  for (const Line& line : lines_) {
    if (line.seq > seen && line.level >= least) out.lines.push_back(line);
  }
  return out;
}

}  // namespace sslv::log
