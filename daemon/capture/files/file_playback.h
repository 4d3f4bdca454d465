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

/// Controls the playback of a recording: which image is next, and when. Its controls are "position",
/// "paused", "step", "step_back", "speed" and "loop". The camera's thread calls wait_turn(); any other thread
/// may set controls at the same time, without a lock.
class Playback final : public Controls {
 public:
  /// `count`: number of images, as far as known. `rate_hz` 0: images are shown as fast as they are taken.
  Playback(std::int64_t count, double rate_hz, bool loop);
  /// `distances_s`: times from each image to the next, and from the last image to the first.
  Playback(std::vector<double> distances_s, bool loop);

  /// Waits until an image is due and returns its number, which may be beyond the last image; nothing if no
  /// image is due within `timeout`.
  std::optional<std::int64_t> wait_turn(std::chrono::milliseconds timeout);
  /// Whether image `place` follows the last turn, that is, no other position was set since.
  bool is_next(std::int64_t place) const { return State::of(state_).next == place; }
  /// Sets the actual number of images. True if the first image is to be shown next.
  bool begin_again(std::int64_t count);

  std::vector<Control> list() override;
  Control get(const std::string& name) override;

 private:
  using Clock = std::chrono::steady_clock;
  void write(const Control& control, const Json& value) override;

  /// The state that wait_turn() and the controls change, packed into one atomic word.
  struct State {
    std::int64_t next = 0;  // number of the next image
    int steps = 0;          // images still to be shown while paused
    bool paused = false, loop = false;

    static State of(std::uint64_t word);
    std::uint64_t word() const;
  };
  template <class Change>
  State update(const Change& change);

  bool is_timed() const { return rate_hz_ > 0 || !distances_s_.empty(); }
  Clock::duration time_after(std::int64_t place) const;

  const double rate_hz_;
  const std::vector<double> distances_s_;  // if empty, the rate is used
  std::atomic<std::uint64_t> state_;
  std::atomic<std::int64_t> count_;
  std::atomic<double> speed_{1};
  std::atomic<bool> is_due_at_once_{false};  // a control was set: the next image is due now
  Bell changed_;
  Clock::time_point due_ = Clock::now();  // used only by the camera's thread
};

}  // namespace sslv
