// SPDX-License-Identifier: Apache-2.0
#include "recording/match_log_player.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

constexpr double kNanosecond_s = 1e-9;

}  // namespace

MatchLogPlayer::MatchLogPlayer(const std::filesystem::path& log)
    : index_(match_log_index(log)), reader_(log) {
  read_next();
}

double MatchLogPlayer::at_s_of(std::int64_t time_ns) const {
  return static_cast<double>(time_ns - index_.first_ns) * kNanosecond_s;
}

double MatchLogPlayer::length_s() const {
  return at_s_of(index_.last_ns);
}

void MatchLogPlayer::read_next() {
  has_next_ = reader_.next(next_);
}

std::optional<double> MatchLogPlayer::play(double now_s, const Send& send) {
  if (is_paused_ || !has_next_) {
    played_s_.reset();
    return std::nullopt;
  }
  // After a late call, playback catches up.
  double passed_s = played_s_ ? std::max(0.0, now_s - *played_s_) * speed_ : 0;
  played_s_ = now_s;
  for (int given = 0; has_next_ && given < kMaxAtOnce; ++given) {
    double gap_s = std::max(0.0, at_s_of(next_.time_ns) - at_s_);  // 0 if a clock was set back
    if (longest_gap_s_ > 0 && gap_s > longest_gap_s_) {
      at_s_ += gap_s - longest_gap_s_;
      gap_s = longest_gap_s_;
    }
    if (gap_s > passed_s) {
      at_s_ += passed_s;
      return (gap_s - passed_s) / speed_;
    }
    passed_s -= gap_s;
    at_s_ = at_s_of(next_.time_ns);
    send(next_);
    read_next();
  }
  if (!has_next_) return std::nullopt;
  // More messages are due: leave the unused time to the next call.
  played_s_ = now_s - passed_s / speed_;
  return 0;
}

void MatchLogPlayer::set_speed(double speed) {
  speed_ = std::clamp(speed, kMinSpeed, kMaxSpeed);
}

void MatchLogPlayer::pause(bool is_paused) {
  is_paused_ = is_paused;
  played_s_.reset();
}

void MatchLogPlayer::go_to(double at_s) {
  at_s_ = std::clamp(at_s, 0.0, length_s());
  reader_.go_to(index_.first_ns + std::llround(at_s_ / kNanosecond_s), index_);
  read_next();
  played_s_.reset();
  event_ns_.reset();
}

bool MatchLogPlayer::step(const Send& send) {
  while (has_next_) {
    at_s_ = at_s_of(next_.time_ns);
    send(next_);
    const bool was_vision = next_.type == LoggedMessage::kVision2014;
    read_next();
    if (was_vision) return true;
  }
  return false;
}

bool MatchLogPlayer::jump(MatchEvent::Kind kind, bool forwards) {
  const std::int64_t at_ns = index_.first_ns + std::llround(at_s_ / kNanosecond_s);
  // A jump ends before its event. Until playback has passed that event, search from the event instead of the
  // position.
  const std::int64_t here_ns = std::max(at_ns, event_ns_.value_or(at_ns));
  const MatchEvent* found = nullptr;
  for (const MatchEvent& event : index_.events) {
    if (event.kind != kind || (forwards ? event.time_ns <= here_ns : event.time_ns >= here_ns)) continue;
    // Kicks are reported late, so events may not be in time order.
    if (!found || (forwards ? event.time_ns < found->time_ns : event.time_ns > found->time_ns))
      found = &event;
  }
  if (!found) return false;
  go_to(at_s_of(found->time_ns) - kBeforeEvent_s);
  event_ns_ = found->time_ns;
  return true;
}

}  // namespace sslv
