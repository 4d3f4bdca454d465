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

/// Plays a log: passes on its messages with their recorded gaps, at any speed. The caller provides the clock
/// and sends the messages.
class MatchLogPlayer {
 public:
  using Send = std::function<void(const LoggedMessage&)>;

  static constexpr double kMinSpeed = 0.1, kMaxSpeed = 16;
  /// Limit of messages per play(), so that a caller can check for a stop request between two calls.
  static constexpr int kMaxAtOnce = 10'000;

  /// Reads the log's index, or makes it. Starts at the log's beginning, not paused. Throws StorageError.
  explicit MatchLogPlayer(const std::filesystem::path& log);

  const MatchLogIndex& index() const { return index_; }
  double length_s() const;
  /// Playback position, in s since the log's first message.
  double at_s() const { return at_s_; }
  double speed() const { return speed_; }
  bool is_paused() const { return is_paused_; }
  /// All messages were sent, or the rest cannot be read (problem()). Playback resumes after going back.
  bool is_at_end() const { return !has_next_; }
  const std::string& problem() const { return reader_.problem(); }

  /// Sends the messages that are due at `now_s` (any steady clock). Returns the seconds until the next
  /// message is due; none: paused or at the end.
  std::optional<double> play(double now_s, const Send& send);

  /// Clamped to kMinSpeed .. kMaxSpeed.
  void set_speed(double speed);
  void pause(bool is_paused);
  /// Shortens longer gaps between messages to `seconds`; 0: shortens none.
  void set_longest_gap(double seconds) { longest_gap_s_ = seconds; }
  /// `at_s`: s since the log's first message, clamped to the log.
  void go_to(double at_s);
  /// While paused: sends all messages up to and including the next vision message. False at the end.
  bool step(const Send& send);
  /// Goes to kBeforeEvent_s before the next event of that kind (the previous one if not `forwards`), to show
  /// what led to it. False: there is none.
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
  std::optional<double> played_s_;  // clock time up to which it has played; none: starts at the next play()
  std::optional<std::int64_t> event_ns_;  // target of the last jump(), so that the next one differs
};

}  // namespace sslv
