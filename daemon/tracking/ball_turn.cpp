// SPDX-License-Identifier: Apache-2.0
// Measurements outside a track's gate: the ball was kicked, was deflected, or reappears after being hidden.
#include "tracking/ball_track.h"
#include "tracking/planar.h"

#include <algorithm>
#include <cmath>

namespace sslv {

using Eigen::Vector2d;

namespace {

Vector2d ahead_of(const TrackedRobot& robot) {
  return {std::cos(robot.orientation_rad), std::sin(robot.orientation_rad)};
}

}  // namespace

void BallTrack::Branch::add(const BallObservation& one) {
  if (count < seen.size()) ++count;
  seen[count - 1] = one;
}

bool BallTrack::Branch::lies() const {
  constexpr double kLies_mm_s = 150, kShakesMm = 4;
  return count > 1 && (last().place_mm - first().place_mm).norm() < kLies_mm_s * passed_s() + kShakesMm;
}

bool BallTrack::Branch::is_straight() const {
  constexpr double kOffMm = 10;
  const Vector2d goes_mm_s = velocity();
  return std::all_of(
      seen.begin(), seen.begin() + static_cast<std::ptrdiff_t>(count), [&](const BallObservation& one) {
        return (first().place_mm + goes_mm_s * (one.t_s - first().t_s) - one.place_mm).norm() < kOffMm;
      });
}

/// Whether `now` gives a plausible velocity with the branch's first measurement: at least kApart_s later, and
/// slower than kFastest_mm_s.
bool BallTrack::tells_a_way(const Branch& branch, const BallObservation& now) {
  constexpr double kFastest_mm_s = 9500;
  const double passed_s = now.t_s - branch.first().t_s;
  return passed_s >= kApart_s && (now.place_mm - branch.first().place_mm).norm() < kFastest_mm_s * passed_s;
}

void BallTrack::forget_branches() {
  for (Branch& branch : branches_) branch.count = 0;
}

BallTrack::Saw BallTrack::surprise(const std::vector<BallObservation>& seen, const Vector2d& expected_mm,
                                   const RobotTracks& robots, std::optional<BallTrack>& before) {
  constexpr double kLasts_s = 0.12, kBranch_mm_s = 7500, kBranchMm = 10, kReach_mm_s = 9000, kReachMm = 25;
  const double t_s = seen.front().t_s;
  for (Branch& branch : branches_) {
    if (branch.count > 0 && t_s - branch.first().t_s > kLasts_s) branch.count = 0;
  }
  // A ball rising off a kicker is projected to a different floor position by each camera. A trajectory needs
  // two measurements of the same camera; for a kick, measurements of two cameras are sufficient (see
  // explain()).
  const bool may_rise = phase_ == Phase::kHeld;
  for (const BallObservation& one : seen) {
    Branch *own = nullptr, *others = nullptr;
    double best = 1, best_of_others = 1;
    for (Branch& branch : branches_) {
      if (branch.count == 0 || branch.last().t_s == t_s) continue;
      const double ratio = (one.place_mm - branch.last().place_mm).norm() /
                           (kBranch_mm_s * std::abs(t_s - branch.last().t_s) + kBranchMm);
      const bool is_own = !may_rise || branch.last().camera_mm == one.camera_mm;
      if (ratio >= (is_own ? best : best_of_others)) continue;
      (is_own ? best : best_of_others) = ratio;
      (is_own ? own : others) = &branch;
    }
    if (!own && others && tells_a_way(*others, one)) {
      Branch both = *others;
      both.add(one);
      before = *this;
      if (explain(both, robots) == Saw::kTurn) return Saw::kTurn;
    }
    if (!own) {
      if ((one.place_mm - expected_mm).norm() >= kReach_mm_s * (t_s - seen_s_) + kReachMm) continue;
      own = &*std::min_element(branches_.begin(), branches_.end(), [](const Branch& a, const Branch& b) {
        return (a.count > 0 ? a.last().t_s : 0) < (b.count > 0 ? b.last().t_s : 0);
      });
      own->count = 0;
      if (was_on_its_way(one, robots)) own->add(held_seen_);
    }
    if (own->count == 0) announce(one, robots);
    const bool tells = own->count > 0 && tells_a_way(*own, one);
    own->add(one);
    if (own->count < 2 || own->passed_s() < kApart_s) continue;
    if (!tells) {
      own->count = 0;
      own->add(one);
      continue;
    }
    before = *this;
    const Branch turned = *own;
    if (explain(turned, robots) == Saw::kTurn) return Saw::kTurn;
  }
  return Saw::kNothing;
}

/// Whether a held ball was already leaving towards `now` at its previous measurement, held_seen_.
bool BallTrack::was_on_its_way(const BallObservation& now, const RobotTracks& robots) const {
  if (phase_ != Phase::kHeld) return false;
  constexpr double kLately_s = 0.03, kShakes = 2;
  const double passed_s = now.t_s - held_seen_.t_s;
  if (passed_s < kApart_s || passed_s > kLately_s) return false;
  const Vector2d way = unit_of(now.place_mm - held_at(now.t_s, robots)),
                 off = held_seen_.place_mm - held_at(held_seen_.t_s, robots);
  const double shakes_mm = kShakes * std::sqrt(held_var_mm2_);
  return off.dot(way) > shakes_mm && std::abs(off.dot(left_of(way))) < shakes_mm;
}

/// Announces a kick from a single measurement: a held ball was kicked if it is ahead of its robot and its
/// lowest possible speed since the previous measurement is at least kSlowest_mm_s. Until the next
/// measurement, the ball's speed is assumed to be the mean of this lowest speed and kAllowed_mm_s.
void BallTrack::announce(const BallObservation& now, const RobotTracks& robots) {
  if (phase_ != Phase::kHeld || is_announced_) return;
  constexpr double kLately_s = 0.03, kSlowest_mm_s = 2000, kFastest_mm_s = 8000, kAllowed_mm_s = 6500,
                   kNearestMm = 25, kAhead_rad = 0.4;
  const double passed_s = now.t_s - held_seen_.t_s;
  const auto robot = robots.at(holder_, now.t_s);
  if (!robot || passed_s < kApart_s || passed_s > kLately_s) return;
  const Vector2d then = held_at(held_seen_.t_s, robots), here = held_at(now.t_s, robots),
                 off = now.place_mm - here, way = unit_of(off);
  const double slowest = (off - (held_seen_.place_mm - then)).norm() / passed_s;
  const bool is_ahead = std::abs(around(direction_of(off) - robot->orientation_rad)) < kAhead_rad;
  if (!is_ahead || off.norm() < kNearestMm || slowest < kSlowest_mm_s || slowest > kFastest_mm_s) return;
  const double speed = std::max(slowest, (slowest + kAllowed_mm_s) / 2);
  const Vector2d held_mm_s = (here - then) / passed_s;
  TrackedKick kick;
  kick.number = kick_ ? kick_->number + 1 : 1;
  kick.t_s = now.t_s - off.norm() / speed;
  kick.place_mm = here - held_mm_s * (now.t_s - kick.t_s);
  kick.velocity_mm_s << held_mm_s + way * speed, 0;
  kick.robot = holder_;
  kick_ = kick;
  is_announced_ = true;
}

/// Whether the robot added speed to the ball, rather than only reflecting it: a passive robot returns only
/// part of the approach speed and hardly changes the tangential speed.
bool BallTrack::pushes(const TrackedRobot& robot, const Vector2d& ball_mm, const Vector2d& before,
                       const Vector2d& after) {
  constexpr double kGivesBack = 0.7, kMore_mm_s = 400, kLeaves_mm_s = 1000, kChanges = 0.4;
  const Vector2d away = unit_of(ball_mm - robot.place_mm), past = left_of(away);
  const double comes = std::max(0.0, -(before - robot.velocity_mm_s).dot(away)),
               leaves = (after - robot.velocity_mm_s).dot(away),
               passes = std::abs((before - robot.velocity_mm_s).dot(past)),
               changes = std::abs((after - before).dot(past));
  return leaves > kGivesBack * comes + kMore_mm_s ||
         (leaves > kLeaves_mm_s && changes > kChanges * passes + kMore_mm_s);
}

/// Closest approach of the old trajectory and the new one, extrapolated backwards from the branch.
BallTrack::Meeting BallTrack::meeting_of(const Branch& branch, const RobotTracks& robots) const {
  const BallObservation& first = branch.first();
  const Vector2d velocity = branch.velocity(), way = unit_of(velocity);
  const double speed = velocity.norm();
  const auto old_at = [&](double t_s) { return seen_from(first.camera_mm, t_s, robots); };
  Meeting out{first.t_s, 1e18, {0, 0}, {0, 0}};
  constexpr double kBefore_s = 0.01, kLongest_s = 0.25, kStep_s = 0.0005;
  for (double t_s = std::max(seen_s_ - kBefore_s, first.t_s - kLongest_s); t_s <= first.t_s; t_s += kStep_s) {
    const double u = first.t_s - t_s, came_mm = speed * u + 0.5 * model_.slides_mm_s2 * u * u;
    const double off_mm = (first.place_mm - way * came_mm - old_at(t_s)).norm();
    if (off_mm >= out.off_mm) continue;
    out.off_mm = off_mm;
    out.t_s = t_s;
  }
  out.place_mm = old_at(out.t_s);
  out.before_mm_s = phase_ == Phase::kFree ? flat_.velocity()
                                           : Vector2d((out.place_mm - old_at(out.t_s - kApart_s)) / kApart_s);
  return out;
}

/// Continues the track with the branch's measurements.
void BallTrack::follow(const Branch& branch) {
  point_count_ = 0;
  for (std::size_t i = 0; i < branch.count; ++i) add_point(branch.seen[i]);
  sightings_ = static_cast<int>(branch.count);
  seen_s_ = branch.last().t_s;
  seen_mm_ = branch.last().place_mm;
  forget_branches();
}

/// Locates the event (kick or deflection) where the old and the new trajectory meet, and continues on the new
/// trajectory. Returns kNothing if the branch does not show a turn, or not yet.
BallTrack::Saw BallTrack::explain(const Branch& branch, const RobotTracks& robots) {
  const BallObservation &first = branch.first(), &last = branch.last();
  // A stationary object that appears elsewhere is clutter, until it has lasted for kLasts measurements.
  constexpr double kHidden_s = 0.05;
  constexpr std::size_t kLasts = 6;
  if (branch.lies() && branch.count < kLasts && first.t_s - seen_s_ > kHidden_s) return Saw::kNothing;
  const Vector2d velocity = branch.velocity(), way = unit_of(velocity);
  const double speed = velocity.norm(), slows_mm_s = model_.slides_mm_s2 * branch.passed_s() / 2;
  const bool was_held = phase_ == Phase::kHeld;
  const Meeting event = meeting_of(branch, robots);
  auto near = robots.nearest(event.place_mm, event.t_s);
  if (was_held) {
    if (const auto holder = robots.at(holder_, event.t_s))
      near = RobotTracks::Nearest{*holder, (event.place_mm - holder->place_mm).norm(), 0};
  }
  // No kicker reaches a ball in the air; a ball that bounces goes on flying.
  const bool is_high = is_in_the_air(event.t_s) || bounces(event.t_s);
  bool is_kick = false;
  constexpr double kReachMm = 150, kFront_rad = 0.8, kKicks_mm_s = 400, kAhead_rad = 0.4,
                   kHeldAhead_rad = 1.2, kKeeps = 0.6;
  double off_front = 0;
  if (near && !is_high) {
    const TrackedRobot& robot = near->robot;
    off_front =
        std::abs(around(direction_of(velocity - kKeeps * robot.velocity_mm_s) - robot.orientation_rad));
    is_kick = near->distance_mm < kReachMm && near->from_front_rad < kFront_rad &&
              off_front < (was_held ? kHeldAhead_rad : kAhead_rad) &&
              (velocity - event.before_mm_s).norm() > kKicks_mm_s &&
              (was_held || pushes(robot, event.place_mm, event.before_mm_s, velocity));
  }
  // Measurements of two cameras give the trajectory of a held ball only if it was kicked straight ahead.
  if (was_held && first.camera_mm != last.camera_mm && (!is_kick || off_front > kAhead_rad))
    return Saw::kNothing;
  constexpr double kMeetsMm = 120, kTouchesMm = 200, kTurns_mm_s = 400;
  constexpr double kBesideMm = 100;
  const bool is_inside = std::abs(event.place_mm.x()) < model_.half_length_mm &&
                         std::abs(event.place_mm.y()) < model_.half_width_mm + kBesideMm;
  const bool touches_nothing = !near || near->distance_mm > kTouchesMm;
  if (event.off_mm > kMeetsMm ||
      (touches_nothing && is_inside && (velocity - event.before_mm_s).norm() < kTurns_mm_s)) {
    constexpr std::size_t kEnough = 3;
    constexpr double kSlides_mm_s = 1500;
    if (branch.count < kEnough || !branch.is_straight()) return Saw::kNothing;
    roll(last, velocity, speed > kSlides_mm_s, speed);
    is_kick_ = false;
    follow(branch);
    return Saw::kTurn;
  }
  if (is_high) {
    turn_in_the_air(branch, event.t_s);
    return Saw::kTurn;
  }
  const double shot_speed = speed + model_.slides_mm_s2 * (first.t_s - event.t_s) + slows_mm_s;
  const bool was_announced = is_announced_;
  roll(last, velocity - way * slows_mm_s, true, shot_speed);
  event_s_ = event.t_s;
  event_mm_ = event.place_mm;
  before_mm_s_ = event.before_mm_s;
  is_kick_ = is_kick;
  is_chip_ = false;
  follow(branch);
  left_holder_ = was_held && !is_kick;
  if (is_kick) begin_kick(near->robot, way * shot_speed, !was_announced);
  return Saw::kTurn;
}

void BallTrack::begin_kick(const TrackedRobot& robot, const Vector2d& velocity_mm_s, bool is_new) {
  TrackedKick kick;
  kick.number = (kick_ ? kick_->number : 0) + (is_new ? 1 : 0);
  kick.t_s = event_s_;
  kick.place_mm = event_mm_;
  kick.velocity_mm_s << velocity_mm_s, 0;
  kick.robot = robot.name;
  kick_ = kick;
  is_kick_ = true;
  kicker_ = {ahead_of(robot), robot.velocity_mm_s};
  fit_shot();
}

/// A deflection in the air: the horizontal motion is estimated again, the vertical motion continues.
void BallTrack::turn_in_the_air(const Branch& branch, double event_s) {
  flight_ = flight_at(event_s);
  constexpr double kMetSigmaMm = 40;
  flight_.turn(kMetSigmaMm);
  for (std::size_t i = 0; i < branch.count; ++i) flight_.correct(point_of(branch.seen[i]), model_);
  fly(flight_);
  event_s_ = event_s;
  follow(branch);
}

/// The newest branch that may be the hidden ball, before its new trajectory is known; null if there is none.
const BallTrack::Branch* BallTrack::reappears(double t_s, const RobotTracks& robots) const {
  constexpr double kHidden_s = 0.02, kLong_s = 0.5, kLately_s = 0.06;
  const Branch* out = nullptr;
  for (const Branch& branch : branches_) {
    if (branch.count == 0 || branch.lies()) continue;
    const double last_s = branch.last().t_s;
    if ((last_s - seen_s_ < kHidden_s && !is_announced_) || t_s - last_s > kLately_s) continue;
    // After a long gap, or far from the robot that hides the ball, a single measurement is just as likely to
    // be clutter.
    constexpr double kFarMm = 700;
    const auto hides = branch.count < 2 && beside_ && phase_ != Phase::kFlying
                           ? robots.at(beside_->robot, last_s)
                           : std::nullopt;
    const bool is_far = hides && (branch.last().place_mm - hides->place_mm).norm() > kFarMm;
    if ((last_s - seen_s_ > kLong_s || is_far) && branch.count < 2) continue;
    if (!out || last_s > out->last().t_s) out = &branch;
  }
  return out;
}

/// Predicts the state at `t_s` of the ball found by reappears(). Returns false if the ball would be faster
/// than any ball can be.
bool BallTrack::where_it_reappears(const Branch& branch, double t_s, BallState& out) const {
  constexpr double kFastest_mm_s = 7500;
  const BallObservation &first = branch.first(), &last = branch.last();
  if (is_in_the_air(first.t_s)) {
    BallFlight flight = flight_at(first.t_s);
    flight.turn((first.t_s - seen_s_) * kFastest_mm_s);
    for (std::size_t i = 0; i < branch.count; ++i) flight.correct(point_of(branch.seen[i]), model_);
    out = flight.shot(model_).at(t_s, model_);
  } else {
    const Vector2d velocity = branch.count > 1 && branch.passed_s() > kApart_s ? branch.velocity()
                              : is_announced_ ? Vector2d(kick_->velocity_mm_s.head<2>())
                                              : Vector2d((last.place_mm - seen_mm_) / (last.t_s - seen_s_));
    out.place_mm << last.place_mm + velocity * (t_s - last.t_s), model_.radius_mm;
    out.velocity_mm_s << velocity, 0;
  }
  return out.velocity_mm_s.norm() < kFastest_mm_s;
}

}  // namespace sslv
