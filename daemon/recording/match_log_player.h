// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_log_index.h"
#include "recording/match_log_reader.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace sslv {

/// Plays a log: gives its messages as far apart as they came, at any speed. The caller owns the clock and
/// sends them.
class MatchLogPlayer {
 public:
  using Send = std::function<void(const LoggedMessage&)>;

  static constexpr double kMinSpeed = 0.1, kMaxSpeed = 16;
  /// play() gives no more than so many at once, so that its caller can still be told to stop.
  static constexpr int kMaxAtOnce = 10'000;

  /// Reads the log's index, or makes it. It plays from the log's beginning, at once. Throws StorageError.
  explicit MatchLogPlayer(const std::filesystem::path& log);

  const MatchLogIndex& index() const { return index_; }
  double length_s() const;
  /// s since the log's first message: the one that was given last, or where it was told to go.
  double at_s() const { return at_s_; }
  double speed() const { return speed_; }
  bool is_paused() const { return is_paused_; }
  /// All was given, or the log cannot be read on (problem()). Going back goes on.
  bool is_at_end() const { return !has_next_; }
  const std::string& problem() const { return reader_.problem(); }

  /// Gives what is due at `now_s`, of any steady clock; for how long nothing is due then. None: it is paused
  /// or at its end.
  std::optional<double> play(double now_s, const Send& send);

  /// Kept within kMinSpeed .. kMaxSpeed.
  void set_speed(double speed);
  void pause(bool is_paused);
  /// Longer gaps are cut to that; 0: none is.
  void set_longest_gap(double seconds) { longest_gap_s_ = seconds; }
  /// Kept within the log.
  void go_to(double at_s);
  /// While paused: gives all up to the next message of vision, that included. False at the end.
  bool step(const Send& send);
  /// Goes to the next event of that kind (or the one before, if not `forwards`), if there is one: two seconds
  /// before it, so that one sees how it came. False: there is none.
  bool jump(MatchEvent::Kind kind, bool forwards);

  static constexpr double kBeforeEvent_s = 2;

 private:
  double at_s_of(std::int64_t time_ns) const;
  void read_next();

  const MatchLogIndex index_;
  MatchLogReader reader_;
  LoggedMessage next_;
  bool has_next_ = false;
  double at_s_ = 0, speed_ = 1, longest_gap_s_ = 0;
  bool is_paused_ = false;
  std::optional<double>
      played_s_;  // the clock up to which it was played; none: it begins with the next play()
  std::optional<std::int64_t> event_ns_;  // that it went to last, so that the next one is another
};

}  // namespace sslv
