// SPDX-License-Identifier: Apache-2.0
#include "capture/files/file_playback.h"

#include "base/error.h"

#include <algorithm>

#include <fmt/format.h>

namespace sslv {

Playback::Playback(std::int64_t count, double rate_hz, bool loop)
    : rate_hz_(rate_hz), count_(count), loop_(loop) {}

std::optional<std::int64_t> Playback::wait_turn(std::chrono::milliseconds timeout) {
  const Clock::time_point until = Clock::now() + timeout;
  std::unique_lock lock(mutex_);
  for (;;) {
    const bool steps = paused_ && steps_ > 0;
    const bool may_go_on = !paused_ || steps;
    const Clock::time_point now = Clock::now();
    if (may_go_on && (rate_hz_ == 0 || steps || now >= due_)) break;
    if (now >= until) return std::nullopt;
    changed_.wait_until(lock, may_go_on ? std::min(until, due_) : until);
  }
  if (steps_ > 0) --steps_;
  if (rate_hz_ > 0) {
    const auto period =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / (rate_hz_ * speed_)));
    // A reader that comes late is not rushed afterwards.
    due_ = std::max(due_ + period, Clock::now());
  }
  return next_++;
}

bool Playback::begin_again(std::int64_t count) {
  const std::lock_guard lock(mutex_);
  count_ = count;
  next_ = loop_ ? 1 : count;
  return loop_;
}

std::vector<Control> Playback::list() {
  const std::lock_guard lock(mutex_);
  std::vector<Control> out(6);
  for (Control& control : out) control.category = "Playback";
  out[0].name = "position";
  out[0].title = "Position";
  out[0].help = "number of the newest picture; setting it shows that one next";
  out[0].kind = ControlKind::kInteger;
  out[0].least = 0;
  out[0].most = static_cast<double>(std::max<std::int64_t>(0, count_ - 1));
  out[0].value = std::max<std::int64_t>(0, next_ - 1);
  out[1].name = "paused";
  out[1].title = "Paused";
  out[1].kind = ControlKind::kFlag;
  out[1].value = paused_;
  out[2].name = "step";
  out[2].title = "Step";
  out[2].help = "shows the next picture and stays paused";
  out[2].kind = ControlKind::kAction;
  out[3].name = "step_back";
  out[3].title = "Step back";
  out[3].help = "shows the picture before and stays paused";
  out[3].kind = ControlKind::kAction;
  out[4].name = "speed";
  out[4].title = "Speed";
  out[4].help = "times its own rate";
  out[4].kind = ControlKind::kNumber;
  out[4].least = 0.01;
  out[4].most = 100;
  out[4].value = speed_;
  out[4].writable = rate_hz_ > 0;
  out[5].name = "loop";
  out[5].title = "Loop";
  out[5].help = "begin again at the end";
  out[5].kind = ControlKind::kFlag;
  out[5].value = loop_;
  return out;
}

Control Playback::get(const std::string& name) {
  for (Control& control : list()) {
    if (control.name == name) return std::move(control);
  }
  throw SettingsError(fmt::format("{}: a recording has no such control", name));
}

ControlEffect Playback::write(const Control& control, const Json& value) {
  if (!control.writable)
    throw SettingsError("speed: cannot be set: these pictures are shown as fast as they are taken");
  {
    const std::lock_guard lock(mutex_);
    if (control.name == "position") {
      next_ = value.get<std::int64_t>();
      steps_ = paused_ ? 1 : 0;
    } else if (control.name == "paused") {
      paused_ = value.get<bool>();
      steps_ = 0;
    } else if (control.name == "step") {
      paused_ = true;
      ++steps_;
    } else if (control.name == "step_back") {
      paused_ = true;
      next_ = std::max<std::int64_t>(0, next_ - 2);
      ++steps_;
    } else if (control.name == "speed") {
      speed_ = value.get<double>();
    } else {
      loop_ = value.get<bool>();
    }
    due_ = Clock::now();
  }
  changed_.notify_all();
  return ControlEffect::kAtOnce;
}

}  // namespace sslv
