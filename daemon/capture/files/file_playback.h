// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/futex.h"
#include "capture/controls.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace sslv {

/// How a recording is played: which image is next, and when. Its controls are "position", "paused", "step",
/// "step_back", "speed" and "loop". The camera's thread takes turns, any other may set controls meanwhile,
/// without a lock.
class Playback final : public Controls {
 public:
  /// `count`: images of the recording, as far as is known. `rate_hz` 0: as fast as they are taken.
  Playback(std::int64_t count, double rate_hz, bool loop);
  /// So long after each image the next one comes, in s, and after the last one the first again.
  Playback(std::vector<double> distances_s, bool loop);

  /// Waits until an image is due and says which one, which may be beyond the last; nothing when none is due
  /// within `timeout`.
  std::optional<std::int64_t> wait_turn(std::chrono::milliseconds timeout);
  /// Image `place` is the one after the last turn: nobody has set another position since.
  bool is_next(std::int64_t place) const { return State::of(state_).next == place; }
  /// The recording turned out to have so many images. True when the first one is to be shown instead.
  bool begin_again(std::int64_t count);

  std::vector<Control> list() override;
  Control get(const std::string& name) override;

 private:
  using Clock = std::chrono::steady_clock;
  void write(const Control& control, const Json& value) override;

  /// What both sides change, in one word.
  struct State {
    std::int64_t next = 0;  // image
    int steps = 0;          // images still to be shown in spite of the pause
    bool paused = false, loop = false;

    static State of(std::uint64_t word);
    std::uint64_t word() const;
  };
  template <class Change>
  State update(const Change& change);

  bool is_timed() const { return rate_hz_ > 0 || !distances_s_.empty(); }
  Clock::duration time_after(std::int64_t place) const;

  const double rate_hz_;
  const std::vector<double> distances_s_;  // empty: the rate counts
  std::atomic<std::uint64_t> state_;
  std::atomic<std::int64_t> count_;
  std::atomic<double> speed_{1};
  std::atomic<bool> is_due_at_once_{false};  // a control was set
  Bell changed_;
  Clock::time_point due_ = Clock::now();  // the camera's thread's own
};

}  // namespace sslv
