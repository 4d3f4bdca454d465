// SPDX-License-Identifier: Apache-2.0
// Validates results between the stages and before they are published.
#include "pipeline/camera_stage.h"
#include "pipeline/field_stage.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace sslv {
namespace {

template <class Floor, class T, class Frame>
void drop_from(Frame& frame, T Frame::*member, const PartSet& changed, InvalidCounts& out) noexcept {
  if (changed[part_index<Floor, T>()]) out += drop_invalid(frame.*member);
}

template <class T>
bool all_make_sense(const std::vector<T>& list, std::size_t most) noexcept {
  return list.size() <= most && std::ranges::all_of(list, [](const T& one) { return is_valid(one); });
}

/// Copies the valid elements, at most `most`. Returns the number of elements left out.
template <class T>
std::uint64_t copy_sense(const std::vector<T>& from, std::size_t most, std::vector<T>& to) noexcept {
  to.clear();
  for (const T& one : from) {
    if (to.size() < most && is_valid(one)) to.push_back(one);
  }
  return from.size() - to.size();
}

}  // namespace

// The frame's results are validated already, but a stage may publish other results.

void DetectionGuard::publish(const FrameInfo& info, const Scene& scene, const RobotList& robots,
                             const BallList& balls) noexcept {
  if (!is_valid(info, info_)) {
    left_out_ += {robots.robots.size(), balls.balls.size(), 1};
  } else if (all_make_sense(robots.robots, limits::kMaxRobots) &&
             all_make_sense(balls.balls, limits::kMaxBalls)) {
    out_->publish(info, scene, robots, balls);
  } else {
    left_out_.robots += copy_sense(robots.robots, limits::kMaxRobots, robots_.robots);
    left_out_.balls += copy_sense(balls.balls, limits::kMaxBalls, balls_.balls);
    out_->publish(info, scene, robots_, balls_);
  }
}

void FieldGuard::publish(const TrackedField& tracked) noexcept {
  const bool has_sound_kick = !tracked.kick || is_valid(*tracked.kick);
  if (!(tracked.t_s > 0) || !std::isfinite(tracked.t_s)) {
    left_out_ += {tracked.robots.size(), tracked.balls.size(), 1};
  } else if (has_sound_kick && all_make_sense(tracked.robots, limits::kMaxRobots) &&
             all_make_sense(tracked.balls, limits::kMaxFieldBalls)) {
    out_->publish(tracked);
  } else {
    tracked_.number = tracked.number;
    tracked_.t_s = tracked.t_s;
    left_out_.robots += copy_sense(tracked.robots, limits::kMaxRobots, tracked_.robots);
    left_out_.balls += copy_sense(tracked.balls, limits::kMaxFieldBalls, tracked_.balls);
    left_out_.others += has_sound_kick ? 0 : 1;
    tracked_.kick = has_sound_kick ? tracked.kick : std::nullopt;
    out_->publish(tracked_);
  }
}

InvalidCounts CameraFloor::drop_invalid(const Inputs& in, const PartSet& changed,
                                        const Guard& guard) noexcept {
  InvalidCounts out;
  drop_from<CameraFloor>(in.frame, &Frame::robots, changed, out);
  drop_from<CameraFloor>(in.frame, &Frame::balls, changed, out);
  if (changed[part_index<CameraFloor, FrameInfo>()] && !is_valid(in.frame.info, guard.info())) {
    in.frame.info = guard.info();
    ++out.others;
  }
  return out;
}

InvalidCounts FieldFloor::drop_invalid(const Inputs& in, const PartSet& changed, const Guard&) noexcept {
  InvalidCounts out;
  if (changed[part_index<FieldFloor, ArrivedSightings>()]) out += sslv::drop_invalid(in.frame.arrived.image);
  drop_from<FieldFloor>(in.frame, &FieldFrame::sightings, changed, out);
  drop_from<FieldFloor>(in.frame, &FieldFrame::time, changed, out);
  drop_from<FieldFloor>(in.frame, &FieldFrame::observations, changed, out);
  drop_from<FieldFloor>(in.frame, &FieldFrame::tracked, changed, out);
  return out;
}

}  // namespace sslv
