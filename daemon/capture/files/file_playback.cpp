// SPDX-License-Identifier: Apache-2.0
#include "capture/files/file_playback.h"

#include "base/error.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace sslv {

namespace {

// Layout of the state word, from the lowest bit: loop, paused, steps, next.
constexpr int kPausedBit = 1, kStepsBit = 2, kNextBit = 20;
constexpr std::int64_t kMaxSteps = (1 << (kNextBit - kStepsBit)) - 1, kMaxNext = (std::int64_t{1} << 43) - 1;

}  // namespace

Playback::State Playback::State::of(std::uint64_t word) {
  return {.next = static_cast<std::int64_t>(word >> kNextBit),
          .steps = static_cast<int>(word >> kStepsBit & kMaxSteps),
          .paused = (word >> kPausedBit & 1) != 0,
          .loop = (word & 1) != 0};
}

std::uint64_t Playback::State::word() const {
  const auto kept_next = static_cast<std::uint64_t>(std::clamp<std::int64_t>(next, 0, kMaxNext));
  const auto kept_steps = static_cast<std::uint64_t>(std::clamp<std::int64_t>(steps, 0, kMaxSteps));
  return kept_next << kNextBit | kept_steps << kStepsBit | std::uint64_t{paused} << kPausedBit |
         std::uint64_t{loop};
}

Playback::Playback(std::int64_t count, double rate_hz, bool loop)
    : rate_hz_(rate_hz), state_(State{.loop = loop}.word()), count_(count) {}

Playback::Playback(std::vector<double> distances_s, bool loop)
    : rate_hz_(0),
      distances_s_(std::move(distances_s)),
      state_(State{.loop = loop}.word()),
      count_(static_cast<std::int64_t>(distances_s_.size())) {}

/// Returns the changed state.
template <class Change>
Playback::State Playback::update(const Change& change) {
  std::uint64_t word = state_.load();
  State after;
  do {
    after = State::of(word);
    change(after);
  } while (!state_.compare_exchange_weak(word, after.word()));
  return after;
}

/// The time from this image to the next.
Playback::Clock::duration Playback::time_after(std::int64_t place) const {
  constexpr double kMaxDistance_s = 3600;  // limits implausible times in a file
  double distance_s = 1 / rate_hz_;
  if (!distances_s_.empty()) {
    // Beyond the last image, the first image is shown again.
    const auto i = static_cast<std::size_t>(place);
    const double said_s = distances_s_[i < distances_s_.size() ? i : 0];
    distance_s = said_s > 0 ? std::min(said_s, kMaxDistance_s) : 0;  // 0 also for NaN
  }
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(distance_s / speed_));
}

std::optional<std::int64_t> Playback::wait_turn(std::chrono::milliseconds timeout) {
  const Clock::time_point until = Clock::now() + timeout;
  State taken;
  for (;;) {
    const std::uint32_t mark = changed_.mark();
    std::uint64_t word = state_.load();
    taken = State::of(word);
    const bool steps = taken.paused && taken.steps > 0;
    const bool may_go_on = !taken.paused || steps;
    const Clock::time_point now = Clock::now();
    if (is_due_at_once_.exchange(false)) due_ = now;
    if (may_go_on && (!is_timed() || steps || now >= due_)) {
      State after = taken;
      ++after.next;
      if (after.steps > 0) --after.steps;
      if (state_.compare_exchange_strong(word, after.word())) break;
      continue;  // a control was set meanwhile
    }
    if (now >= until) return std::nullopt;
    changed_.wait(mark, may_go_on ? std::min(until, due_) : until);
  }
  // After a late call, do not show the following images faster to catch up.
  if (is_timed()) due_ = std::max(due_ + time_after(taken.next), Clock::now());
  return taken.next;
}

bool Playback::begin_again(std::int64_t count) {
  count_ = count;
  return update([&](State& state) { state.next = state.loop ? 1 : count; }).loop;
}

std::vector<Control> Playback::list() {
  const State state = State::of(state_);
  std::vector<Control> out(6);
  for (Control& control : out) control.category = "Playback";
  out[0].name = "position";
  out[0].title = "Position";
  out[0].help = "number of the current image; setting it shows that image next";
  out[0].kind = ControlKind::kInteger;
  out[0].least = 0;
  out[0].most = static_cast<double>(std::max<std::int64_t>(0, count_ - 1));
  out[0].value = std::max<std::int64_t>(0, state.next - 1);
  out[0].moves = true;
  out[1].name = "paused";
  out[1].title = "Paused";
  out[1].kind = ControlKind::kFlag;
  out[1].value = state.paused;
  out[2].name = "step";
  out[2].title = "Step";
  out[2].help = "shows the next image and stays paused";
  out[2].kind = ControlKind::kAction;
  out[3].name = "step_back";
  out[3].title = "Step back";
  out[3].help = "shows the previous image and stays paused";
  out[3].kind = ControlKind::kAction;
  out[4].name = "speed";
  out[4].title = "Speed";
  out[4].help = "factor on its own rate";
  out[4].kind = ControlKind::kNumber;
  out[4].least = 0.01;
  out[4].most = 100;
  out[4].value = speed_.load();
  out[4].writable = is_timed();
  out[5].name = "loop";
  out[5].title = "Loop";
  out[5].help = "start again at the end";
  out[5].kind = ControlKind::kFlag;
  out[5].value = state.loop;
  return out;
}

Control Playback::get(const std::string& name) {
  for (Control& control : list()) {
    if (control.name == name) return std::move(control);
  }
  throw SettingsError(fmt::format("{}: a recording has no such control", name));
}

void Playback::write(const Control& control, const Json& value) {
  if (!control.writable)
    throw SettingsError("speed: cannot be set: these images are shown as fast as they are processed");
  if (control.name == "speed") speed_ = value.get<double>();
  update([&](State& state) {
    if (control.name == "position") {
      state.next = value.get<std::int64_t>();
      state.steps = state.paused ? 1 : 0;
    } else if (control.name == "paused") {
      state.paused = value.get<bool>();
      state.steps = 0;
    } else if (control.name == "step") {
      state.paused = true;
      ++state.steps;
    } else if (control.name == "step_back") {
      state.paused = true;
      state.next = std::max<std::int64_t>(0, state.next - 2);
      ++state.steps;
    } else if (control.name == "loop") {
      state.loop = value.get<bool>();
    }
  });
  is_due_at_once_ = true;
  changed_.ring();
}

}  // namespace sslv
