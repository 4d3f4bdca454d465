// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/controls.h"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

namespace sslv {

/// How a recording is played: which picture is next, and when. Its controls are "position", "paused", "step",
/// "step_back", "speed" and "loop". The camera's thread takes turns, any other may set controls meanwhile.
class Playback final : public Controls {
 public:
  /// `count`: pictures of the recording, as far as is known. `rate_hz` 0: as fast as they are taken.
  Playback(std::int64_t count, double rate_hz, bool loop);

  /// Waits until a picture is due and says which one, which may be beyond the last; nothing when none is due
  /// within `timeout`.
  std::optional<std::int64_t> wait_turn(std::chrono::milliseconds timeout);
  /// The recording turned out to have so many pictures. True when the first one is to be shown instead.
  bool begin_again(std::int64_t count);

  std::vector<Control> list() override;
  Control get(const std::string& name) override;

 private:
  using Clock = std::chrono::steady_clock;
  ControlEffect write(const Control& control, const Json& value) override;

  const double rate_hz_;
  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::int64_t count_;
  std::int64_t next_ = 0;
  int steps_ = 0;  // pictures still to be shown in spite of the pause
  bool paused_ = false, loop_;
  double speed_ = 1;
  Clock::time_point due_ = Clock::now();
};

}  // namespace sslv
