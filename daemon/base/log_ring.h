// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sslv::log {

enum class Level { kDebug, kInfo, kWarning, kError };

/// "debug", "info", "warning", "error".
std::string_view name_of(Level level);
std::optional<Level> level_named(std::string_view name);

/// The newest lines of a log. Thread-safe.
class LogRing {
 public:
  static constexpr std::size_t kMaxLines = 1000, kMaxBytes = 256 * 1024;
  static constexpr std::size_t kLongestLine = 4096;  // bytes; longer lines are truncated

  struct Line {
    std::uint64_t seq;  // line number, counted from 1
    double time_s;      // Unix time
    Level level;
    std::string text;
  };
  struct Lines {
    std::vector<Line> lines;  // oldest first
    std::uint64_t newest;     // number of the newest line; 0 before the first
  };

  void add(double time_s, Level level, std::string_view text);

  /// Lines with a higher number than `seen`, of this level or worse. All lines if `seen` is higher than the
  /// newest number, because `seen` is then from an earlier run.
  Lines newer_than(std::uint64_t seen, Level least) const;

 private:
  mutable std::mutex mutex_;
  std::deque<Line> lines_;
  std::size_t bytes_ = 0;
  std::uint64_t newest_ = 0;
};

}  // namespace sslv::log
