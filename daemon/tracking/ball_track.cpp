// SPDX-License-Identifier: Apache-2.0
#include "tracking/ball_track.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace sslv {

using Eigen::Matrix2d, Eigen::Vector2d, Eigen::Vector3d;

namespace {

constexpr double kKickLasts_s = 1.2;  // so long a kick's fit says where the ball is
constexpr double kNearlyMm = 111.5;   // between the centres of a robot and a ball that touches it
constexpr double kFlatTimeSigma_s = 0.08e-3;
constexpr double kFreeSlides_mm_s2 = 3500;
constexpr double kApart_s = 0.003;  // between sightings that tell a velocity

double around(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}
double direction_of(const Vector2d& v) {
  return std::atan2(v.y(), v.x());
}
Vector2d unit_of(const Vector2d& v) {
  const double length = v.norm();
  return length > 1e-9 ? Vector2d(v / length) : Vector2d(0, 0);
}
Vector2d turned_by(const Vector2d& v, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}
ShotPoint point_of(const BallObservation& one) {
  return {one.t_s, one.camera_mm, one.place_mm, one.sigma_mm, one.height_mm, one.height_sigma_mm};
}
Vector2d ahead_of(const TrackedRobot& robot) {
  return {std::cos(robot.orientation_rad), std::sin(robot.orientation_rad)};
}
Vector2d left_of(const Vector2d& v) {
  return {-v.y(), v.x()};
}

}  // namespace

BallTrack::BallTrack(const BallModel& model, const BallObservation& newest, const Vector2d& velocity_mm_s,
                     int sightings)
    : model_(model),
      seen_s_(newest.t_s),
      seen_mm_(newest.place_mm),
      sightings_(sightings),
      began_mm_(newest.place_mm) {
  roll(newest, velocity_mm_s, false, velocity_mm_s.norm());
  flat_.cov.diagonal().segment<2>(2).setConstant(1e5);
  add_point(newest);
}

void BallTrack::Flat::predict(double to_s, const BallModel& model) {
  const double passed_s = to_s - t_s;
  if (std::abs(passed_s) < 1e-7) return;
  const Vector2d way = unit_of(velocity());
  const double speed = velocity().norm(), slows = speed > 1 ? state[4] : 0;
  const double goes_s = slows > 0 && passed_s > 0 ? std::min(passed_s, speed / slows) : passed_s;
  Matrix5 step = Matrix5::Identity();
  step(0, 2) = step(1, 3) = passed_s;
  constexpr double kHasDirection_mm_s = 30;
  if (speed > kHasDirection_mm_s) {
    step.block<2, 1>(0, 4) = -0.5 * passed_s * passed_s * way;
    step.block<2, 1>(2, 4) = -passed_s * way;
  }
  state.head<2>() += velocity() * goes_s - 0.5 * slows * way * goes_s * goes_s;
  const double after = std::max(0.0, speed - slows * passed_s);
  state.segment<2>(2) = way * after;
  cov = step * cov * step.transpose();
  const double q = slides ? 3000 : 300, d = std::abs(passed_s);
  for (int i = 0; i < 2; ++i) {
    cov(i, i) += q * d * d * d / 3;
    cov(i, i + 2) += q * d * d / 2;
    cov(i + 2, i) += q * d * d / 2;
    cov(i + 2, i + 2) += q * d;
  }
  cov(4, 4) += (slides ? 1e5 : 2e3) * d;
  t_s = to_s;
  if (!slides || after >= began_mm_s * model.rolls_from_share) return;
  slides = false;
  state[4] = model.rolls_mm_s2;
  cov.row(4).setZero();
  cov.col(4).setZero();
  cov(4, 4) = 80 * 80;
  cov(2, 2) += 900;
  cov(3, 3) += 900;
}

void BallTrack::roll(const BallObservation& at, const Vector2d& velocity_mm_s, bool slides,
                     double began_mm_s) {
  phase_ = Phase::kFree;
  flat_ = {};
  flat_.t_s = at.t_s;
  flat_.state << at.place_mm, velocity_mm_s, slides ? kFreeSlides_mm_s2 : model_.rolls_mm_s2;
  flat_.cov.diagonal() << 0.3, 0.3, 3600, 3600, slides ? 300 * 300 : 80 * 80;
  flat_.slides = slides;
  flat_.began_mm_s = began_mm_s;
  held_count_ = 0;
  surprises_ = 0;
  is_announced_ = left_holder_ = false;
}

Vector2d BallTrack::held_at(double t_s, const RobotTracks& robots) const {
  const auto robot = robots.at(holder_, t_s);
  return robot ? Vector2d(robot->place_mm + turned_by(held_mm_, robot->orientation_rad)) : flat_.place();
}

/// Where a camera sees it, as if it lay on the floor.
Vector2d BallTrack::seen_from(const Vector3d& camera_mm, double t_s, const RobotTracks& robots) const {
  if (phase_ == Phase::kHeld) return held_at(t_s, robots);
  if (phase_ == Phase::kFree) {
    Flat then = flat_;
    then.predict(t_s, model_);
    return then.place();
  }
  const BallState ball = chip_.at(t_s, model_);
  const double farther = (camera_mm.z() - model_.radius_mm) / (camera_mm.z() - ball.place_mm.z());
  return camera_mm.head<2>() + (ball.place_mm.head<2>() - camera_mm.head<2>()) * farther;
}

double BallTrack::gate_mm(double t_s) const {
  const double unseen_s = t_s - seen_s_, age_s = t_s - event_s_;
  switch (phase_) {
    case Phase::kHeld: return std::clamp(3.5 * std::sqrt(held_var_mm2_) + 2, 5.0, 12.0);
    case Phase::kFlying:
      if (!is_kick_) {
        BallFlight then = flight_;
        then.predict(t_s, model_);
        constexpr double kMostMm = 120, kSlope = 0.5;  // of a camera's sight, at most
        const double spread = std::max(then.cov(0, 0), then.cov(1, 1)) + kSlope * kSlope * then.cov(2, 2);
        return std::min(kMostMm, 4.5 * std::sqrt(std::max(0.0, spread)) + 5);
      }
      return 15 + 60 * std::max(0.0, 0.12 - age_s) / 0.12 + 40 * unseen_s + (age_s > 0.35 ? 25 : 0);
    case Phase::kFree: break;
  }
  Flat then = flat_;
  then.predict(t_s, model_);
  return std::min(40.0, 4.5 * std::sqrt(std::max(then.cov(0, 0), then.cov(1, 1)) + 0.3) + 1.5);
}

BallTrack::Saw BallTrack::add(const std::vector<BallObservation>& seen, const RobotTracks& robots,
                              std::optional<BallTrack>& before) {
  if (seen.empty()) return Saw::kNothing;
  const double t_s = seen.front().t_s;
  const Vector2d expected = seen_from(seen.front().camera_mm, t_s, robots);
  const BallObservation& nearest =
      *std::min_element(seen.begin(), seen.end(), [&](const BallObservation& a, const BallObservation& b) {
        return (a.place_mm - expected).norm() < (b.place_mm - expected).norm();
      });
  const double off_mm = (nearest.place_mm - expected).norm();
  bool is_it = off_mm < gate_mm(t_s);
  // A kick that is not yet known to be a chip leaves the floor's path.
  constexpr double kYoung_s = 0.35, kPerPeriodMm = 90, kPeriod_s = 0.0133, kMostMm = 120;
  if (!is_it && phase_ == Phase::kFree && is_kick_ && t_s - event_s_ < kYoung_s)
    is_it = off_mm < gate_mm(t_s) + kPerPeriodMm * (t_s - seen_s_) / kPeriod_s && off_mm < kMostMm;
  if (is_it) {
    forget_branches();
    seen_s_ = t_s;
    seen_mm_ = nearest.place_mm;
    ++sightings_;
    accept(nearest, robots);
    constexpr double kMoves_mm_s = 150, kMovedMm = 12;
    has_moved_ = has_moved_ || (nearest.place_mm - began_mm_).norm() > kMovedMm;
    if (has_moved_ && (phase_ != Phase::kFree || flat_.velocity().norm() > kMoves_mm_s)) moved_s_ = t_s;
    return Saw::kBall;
  }
  return surprise(seen, expected, robots, before);
}

bool BallTrack::explains(const BallObservation& sighting, const RobotTracks& robots) const {
  return (sighting.place_mm - seen_from(sighting.camera_mm, sighting.t_s, robots)).norm() <
         gate_mm(sighting.t_s);
}

bool BallTrack::is_gone(double t_s) const {
  // A robot takes the ball along.
  constexpr double kGone_s = 0.8, kHeldGone_s = 2;
  return t_s - seen_s_ > (phase_ == Phase::kHeld ? kHeldGone_s : kGone_s);
}

bool BallTrack::is_too_fast() const {
  constexpr double kFastest_mm_s = 9000;
  return phase_ == Phase::kFree && flat_.velocity().norm() > kFastest_mm_s;
}

/// Instead of the one that saw it longest ago, when there is none yet.
BallTrack::Border& BallTrack::border_of(const Vector3d& camera_mm) {
  Border* oldest = &borders_[0];
  for (Border& one : borders_) {
    if (one.camera_mm == camera_mm) return one;
    if (one.seen_s < oldest->seen_s) oldest = &one;
  }
  *oldest = {};
  oldest->camera_mm = camera_mm;
  return *oldest;
}

/// Cameras that see it at the same time keep their differences, so that it does not go to and fro between
/// them; what they have in common fades.
Vector2d BallTrack::left_over_at_border(const BallObservation& sighting, const Vector2d& off_mm) {
  constexpr double kNew_s = 0.25, kAlso_s = 0.04, kMostMm = 6, kFades_s = 0.5, kLearns = 0.12;
  Border& border = border_of(sighting.camera_mm);
  const double gap_s = sighting.t_s - border.seen_s;
  const bool is_alone = std::none_of(borders_.begin(), borders_.end(), [&](const Border& one) {
    return &one != &border && sighting.t_s - one.seen_s < kNew_s;
  });
  if (gap_s > kNew_s) border.off_mm = !is_alone && off_mm.norm() < kMostMm ? off_mm : Vector2d(0, 0);
  border.seen_s = sighting.t_s;
  Vector2d common(0, 0);
  int count = 0;
  for (const Border& one : borders_) {
    if (sighting.t_s - one.seen_s > kAlso_s) continue;
    common += one.off_mm;
    ++count;
  }
  common *= (1 - std::exp(-std::clamp(gap_s, 0.0, kAlso_s) / kFades_s)) / count;
  for (Border& one : borders_) {
    if (sighting.t_s - one.seen_s <= kAlso_s) one.off_mm -= common;
  }
  const Vector2d out = border.off_mm;
  if (count > 1 && (off_mm - out).norm() < kMostMm) border.off_mm += kLearns * (off_mm - out);
  return out;
}

void BallTrack::correct(const BallObservation& sighting) {
  flat_.predict(sighting.t_s, model_);
  const Vector2d velocity = flat_.velocity();
  const Matrix2d noise = sighting.sigma_mm * sighting.sigma_mm * Matrix2d::Identity() +
                         kFlatTimeSigma_s * kFlatTimeSigma_s * velocity * velocity.transpose();
  const Vector2d seen_off = sighting.place_mm - flat_.place(),
                 off = seen_off - left_over_at_border(sighting, seen_off);
  Matrix2d spread = flat_.cov.topLeftCorner<2, 2>() + noise;
  const double surprise = off.dot(spread.inverse() * off);
  constexpr double kSurprise = 9;
  if (surprise > kSurprise) {
    ++surprises_;
    flat_.cov.diagonal().segment<2>(2).array() += surprise * 3000;
    flat_.cov.diagonal().head<2>().array() += surprise * 0.3;
    flat_.cov(4, 4) += 1e6;
    spread = flat_.cov.topLeftCorner<2, 2>() + noise;
  }
  const Eigen::Matrix<double, 5, 2> gain = flat_.cov.leftCols<2>() * spread.inverse();
  flat_.state += gain * off;
  flat_.cov -= (gain * flat_.cov.topRows<2>()).eval();
  flat_.cov = (0.5 * (flat_.cov + flat_.cov.transpose())).eval();
  flat_.state[4] =
      flat_.slides ? std::clamp(flat_.state[4], 2500.0, 4500.0) : std::clamp(flat_.state[4], 150.0, 500.0);
}

void BallTrack::accept(const BallObservation& sighting, const RobotTracks& robots) {
  if (phase_ == Phase::kHeld) {
    const auto robot = robots.at(holder_, sighting.t_s);
    if (!robot) return;
    const Vector2d away = sighting.place_mm - robot->place_mm;
    const Vector2d off = turned_by(away, -robot->orientation_rad) - held_mm_;
    // A dribbler shakes it faster than one can follow.
    constexpr double kSlow = 0.1;
    const double gain = std::max(kSlow, 1.0 / ++held_count_);
    held_mm_ += gain * off;
    constexpr double kMostVars = 6;  // more is no shaking
    held_var_mm2_ += kSlow * (std::min(off.squaredNorm(), kMostVars * held_var_mm2_) - held_var_mm2_);
    held_seen_ = sighting;
    is_announced_ = false;
    constexpr double kLetGoMm = 150;
    if (away.norm() > kLetGoMm) roll(sighting, robot->velocity_mm_s, false, robot->velocity_mm_s.norm());
    return;
  }
  const double age_s = sighting.t_s - event_s_;
  if (phase_ == Phase::kFree) correct(sighting);
  if (is_kick_ && age_s < kKickLasts_s) {
    add_point(sighting);
    fit_shot();
  }
  if (phase_ == Phase::kFlying && is_kick_ && age_s >= kKickLasts_s) {
    flight_ = flight_at(sighting.t_s);
    is_kick_ = false;
  }
  if (phase_ == Phase::kFlying && !is_kick_) {
    flight_.correct(point_of(sighting), model_);
    if (flight_.is_over || flight_.is_doubtful()) {
      const Vector2d velocity = flight_.state.segment<2>(3);
      roll(sighting, velocity, false, velocity.norm());
      flat_.cov.diagonal().segment<2>(2).setConstant(4e4);
    } else {
      chip_ = flight_.shot(model_);
    }
  }
  if (phase_ == Phase::kFree && !is_kick_) {
    add_point(sighting);
    may_fly(sighting.t_s, robots);
  }
  may_be_held(sighting, robots);
}

void BallTrack::may_be_held(const BallObservation& sighting, const RobotTracks& robots) {
  if (phase_ != Phase::kFree) return;
  constexpr double kNearMm = 125, kFrontRad = 0.6, kSlow_mm_s = 500, kAfterEvent_s = 0.06;
  constexpr int kSure = 3;
  const auto near = robots.nearest(flat_.place(), sighting.t_s);
  if (!near || near->distance_mm >= kNearMm || near->from_front_rad >= kFrontRad) {
    held_count_ = 0;
    return;
  }
  const Vector2d away = sighting.place_mm - near->robot.place_mm;
  const Vector2d relative =
      flat_.velocity() - near->robot.velocity_mm_s - left_of(away) * near->robot.turn_rad_s;
  if (relative.norm() >= kSlow_mm_s || sighting.t_s - event_s_ <= kAfterEvent_s) {
    held_count_ = 0;
    return;
  }
  if (++held_count_ < kSure) return;
  phase_ = Phase::kHeld;
  held_count_ = 1;
  held_seen_ = sighting;
  constexpr double kShakesMm = 2;
  held_var_mm2_ = kShakesMm * kShakesMm;
  holder_ = near->robot.name;
  held_mm_ = turned_by(away, -near->robot.orientation_rad);
  is_kick_ = false;
}

void BallTrack::Branch::add(const BallObservation& one) {
  if (count < seen.size()) ++count;
  seen[count - 1] = one;
}

bool BallTrack::Branch::lies() const {
  constexpr double kLies_mm_s = 150, kShakesMm = 4;
  return count > 1 && (last().place_mm - first().place_mm).norm() < kLies_mm_s * passed_s() + kShakesMm;
}

/// Whether a ball can have gone from where a branch began to here.
bool BallTrack::tells_a_way(const Branch& branch, const BallObservation& now) {
  constexpr double kFastest_mm_s = 9500;
  const double passed_s = now.t_s - branch.first().t_s;
  return passed_s >= kApart_s && (now.place_mm - branch.first().place_mm).norm() < kFastest_mm_s * passed_s;
}

void BallTrack::forget_branches() {
  for (Branch& branch : branches_) branch.count = 0;
}

/// Whether a held ball was already leaving, towards this sighting, when it was seen before.
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

/// A held ball that is that far ahead one image later was kicked, even if it was as late as can be: how fast
/// is said between what it must have been and what is allowed, until it is seen again.
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

BallTrack::Saw BallTrack::surprise(const std::vector<BallObservation>& seen, const Vector2d& expected_mm,
                                   const RobotTracks& robots, std::optional<BallTrack>& before) {
  constexpr double kLasts_s = 0.12;
  const double t_s = seen.front().t_s;
  for (Branch& branch : branches_) {
    if (branch.count > 0 && t_s - branch.first().t_s > kLasts_s) branch.count = 0;
  }
  // A ball that rises off a kicker is seen elsewhere by each camera: only what one camera sees twice tells
  // its way, unless it is that of a kick.
  const bool may_rise = phase_ == Phase::kHeld;
  for (const BallObservation& one : seen) {
    Branch *own = nullptr, *others = nullptr;
    double best = 1, best_of_others = 1;
    for (Branch& branch : branches_) {
      if (branch.count == 0 || branch.last().t_s == t_s) continue;
      const double ratio =
          (one.place_mm - branch.last().place_mm).norm() / (7500 * std::abs(t_s - branch.last().t_s) + 10);
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
      if ((one.place_mm - expected_mm).norm() >= 9000 * (t_s - seen_s_) + 25) continue;
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

/// A robot that does not kick gives back but some of the speed with which a ball comes, and hardly changes
/// how fast it goes past.
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

/// What happened is where the old way and the new one meet.
BallTrack::Saw BallTrack::explain(const Branch& branch, const RobotTracks& robots) {
  const BallObservation &first = branch.first(), &last = branch.last();
  // What comes to lie elsewhere is no ball, as long as it does not last longer than those do.
  constexpr double kHidden_s = 0.05;
  constexpr std::size_t kLasts = 6;
  if (branch.lies() && branch.count < kLasts && first.t_s - seen_s_ > kHidden_s) return Saw::kNothing;
  const double passed_s = last.t_s - first.t_s;
  const Vector2d velocity = (last.place_mm - first.place_mm) / passed_s, way = unit_of(velocity);
  const double speed = velocity.norm(), slides = model_.slides_mm_s2;
  const bool was_held = phase_ == Phase::kHeld;
  const auto old_at = [&](double t_s) { return seen_from(first.camera_mm, t_s, robots); };
  double event_s = first.t_s, best = 1e18;
  constexpr double kBefore_s = 0.01, kLongest_s = 0.25, kStep_s = 0.0005;
  for (double t_s = std::max(seen_s_ - kBefore_s, first.t_s - kLongest_s); t_s <= first.t_s; t_s += kStep_s) {
    const double u = first.t_s - t_s;
    const double off = (first.place_mm - way * (speed * u + 0.5 * slides * u * u) - old_at(t_s)).norm();
    if (off >= best) continue;
    best = off;
    event_s = t_s;
  }
  const Vector2d event_mm = old_at(event_s);
  const Vector2d before = phase_ == Phase::kFree
                              ? flat_.velocity()
                              : Vector2d((old_at(event_s) - old_at(event_s - kApart_s)) / kApart_s);
  auto near = robots.nearest(event_mm, event_s);
  if (was_held) {
    if (const auto holder = robots.at(holder_, event_s))
      near = RobotTracks::Nearest{*holder, (event_mm - holder->place_mm).norm(), 0};
  }
  const double shot_speed = speed + slides * (first.t_s - event_s + passed_s / 2);
  // No kicker reaches a ball in the air.
  const bool is_high = is_in_the_air(event_s);
  bool is_kick = false;
  constexpr double kKicks_mm_s = 400, kAhead_rad = 0.4;
  double off_front = 0;
  if (near && !is_high) {
    const TrackedRobot& robot = near->robot;
    const Vector2d from_robot = velocity - 0.6 * robot.velocity_mm_s;
    off_front = std::abs(around(direction_of(from_robot) - robot.orientation_rad));
    is_kick = near->distance_mm < 150 && near->from_front_rad < 0.8 &&
              off_front < (was_held ? 1.2 : kAhead_rad) && (velocity - before).norm() > kKicks_mm_s &&
              (was_held || pushes(robot, event_mm, before, velocity));
  }
  // What two cameras see at different times is no way, but that of a kick ahead.
  if (was_held && first.camera_mm != last.camera_mm && (!is_kick || off_front > kAhead_rad))
    return Saw::kNothing;
  constexpr double kMeetsMm = 120, kTouchesMm = 200, kTurns_mm_s = 400;
  const bool is_inside = std::abs(event_mm.x()) < 6000 && std::abs(event_mm.y()) < 4600;
  const bool touches_nothing = !near || near->distance_mm > kTouchesMm;
  if (best > kMeetsMm || (touches_nothing && is_inside && (velocity - before).norm() < kTurns_mm_s)) {
    constexpr std::size_t kEnough = 3;
    if (branch.count < kEnough) return Saw::kNothing;
    sightings_ = static_cast<int>(branch.count);
    roll(last, velocity, speed > 1500, speed);
    point_count_ = 0;
    for (std::size_t i = 0; i < branch.count; ++i) add_point(branch.seen[i]);
    seen_s_ = last.t_s;
    seen_mm_ = last.place_mm;
    forget_branches();
    is_kick_ = false;
    return Saw::kTurn;
  }
  if (is_high) {
    turn_in_the_air(branch, event_s);
    return Saw::kTurn;
  }
  const bool was_announced = is_announced_;
  roll(last, velocity - way * (slides * passed_s / 2), true, shot_speed);
  seen_s_ = last.t_s;
  seen_mm_ = last.place_mm;
  event_s_ = event_s;
  event_mm_ = event_mm;
  before_mm_s_ = before;
  is_kick_ = is_kick;
  is_chip_ = false;
  point_count_ = 0;
  for (std::size_t i = 0; i < branch.count; ++i) add_point(branch.seen[i]);
  sightings_ = static_cast<int>(branch.count);
  forget_branches();
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

/// What is known of the way of a kick's chip.
BallFlight BallTrack::flight_at(double t_s) const {
  constexpr double kPlaceSigmaMm = 20, kVelocitySigma_mm_s = 100;
  const BallState then = chip_.at(t_s, model_);
  BallFlight out;
  out.t_s = t_s;
  out.state << then.place_mm, then.velocity_mm_s;
  out.cov.diagonal() << BallFlight::Vector6::Constant(kVelocitySigma_mm_s * kVelocitySigma_mm_s);
  out.cov.diagonal().head<3>().setConstant(kPlaceSigmaMm * kPlaceSigmaMm);
  out.has_hopped = chip_.has_hopped || t_s > chip_.t_s + chip_.lands_after_s();
  out.is_over = then.velocity_mm_s.z() == 0;
  return out;
}

bool BallTrack::is_in_the_air(double t_s) const {
  constexpr double kInTheAirMm = 60;
  return phase_ == Phase::kFlying && chip_.at(t_s, model_).place_mm.z() > model_.radius_mm + kInTheAirMm;
}

/// What it met turned its way; it falls as before.
void BallTrack::turn_in_the_air(const Branch& branch, double event_s) {
  flight_ = flight_at(event_s);
  constexpr double kMetSigmaMm = 40;
  flight_.turn(kMetSigmaMm);
  point_count_ = 0;
  for (std::size_t i = 0; i < branch.count; ++i) {
    add_point(branch.seen[i]);
    flight_.correct(point_of(branch.seen[i]), model_);
  }
  fly(flight_);
  seen_s_ = branch.last().t_s;
  seen_mm_ = branch.last().place_mm;
  event_s_ = event_s;
  sightings_ = static_cast<int>(branch.count);
  forget_branches();
}

void BallTrack::fly(const BallFlight& flight) {
  phase_ = Phase::kFlying;
  is_kick_ = false;
  flight_ = flight;
  chip_ = flight_.shot(model_);
  event_mm_ = chip_.place_mm;
}

/// A ball that begins anew where nobody saw it kicked may be in the air: its size tells, or its way.
void BallTrack::may_fly(double t_s, const RobotTracks& robots) {
  constexpr double kLongest_s = 0.6, kSurelySigmas = 2.5;
  constexpr int kSurprises = 2;
  if (point_count_ == 0 || point_count_ == points_.size() || t_s - points_[0].t_s > kLongest_s) return;
  const std::span<const ShotPoint> points(points_.data(), point_count_);
  double sigmas = 0;
  for (const ShotPoint& point : points)
    sigmas += (point.height_mm - model_.radius_mm) / point.height_sigma_mm;
  if (sigmas < kSurelySigmas * std::sqrt(static_cast<double>(point_count_)) && surprises_ < kSurprises)
    return;
  const auto flight = find_flight(points, model_);
  if (!flight) return;
  // Nothing else lifts a ball off a robot that holds it.
  const auto kicker = left_holder_ ? robots.at(holder_, event_s_) : std::nullopt;
  if (kicker) {
    const auto before = kick_;
    begin_kick(*kicker, flight->state.segment<2>(3), true);
    if (is_chip_) return;
    kick_ = before;
  }
  fly(*flight);
}

void BallTrack::add_point(const BallObservation& sighting) {
  if (point_count_ < points_.size()) points_[point_count_++] = point_of(sighting);
}

void BallTrack::fit_shot() {
  const std::size_t count = point_count_;
  const std::span<const ShotPoint> points(points_.data(), count);
  constexpr std::size_t kFewest = 3, kOften = 16;
  if (count < kFewest || (count > kOften && count % 2) || count >= kMaxShotPoints) return;
  const double age_s = points.back().t_s - event_s_;
  ShotFit guess;
  guess.shot = {event_s_, event_mm_, kick_->velocity_mm_s};
  guess.shot.velocity_mm_s.z() = 0;
  guess.slides_mm_s2 = kFreeSlides_mm_s2;
  BallModel slides = model_;
  slides.slides_mm_s2 = kFreeSlides_mm_s2;
  ShotPrior prior;
  prior.robot = kicker_;
  const ShotFit flat = fit_flat(guess, points, slides, prior);
  const Vector2d flat_velocity = flat.shot.velocity_mm_s.head<2>();
  const double speed = flat_velocity.norm();

  ShotFit chip_guess;
  chip_guess.shot =
      is_chip_
          ? chip_
          : BallShot{event_s_, event_mm_, {0.9 * flat_velocity.x(), 0.9 * flat_velocity.y(), 0.8 * speed}};
  chip_guess.shot.t_s = event_s_;
  chip_guess.shot.place_mm = event_mm_;
  const ShotFit chip = fit_chip(chip_guess, points, model_, prior, count < 8 ? 6 : 3);
  // One that was turned on its way fits neither.
  constexpr double kMostEach = 6, kMost = 20;
  const bool fits = chip.chi2 < kMostEach * static_cast<double>(count) + kMost;
  is_chip_ = fits && flat.chi2 - chip.chi2 > (is_chip_ ? -5 : 14);
  chip_ = chip.shot;
  kick_->is_chip = is_chip_;
  if (is_chip_) {
    phase_ = Phase::kFlying;
    kick_->t_s = chip.shot.t_s;
    kick_->velocity_mm_s = chip.shot.velocity_mm_s;
    kick_->landing_mm = chip.shot.landing_mm();
    return;
  }
  if (phase_ == Phase::kFlying) {
    const ShotPoint& last = points.back();
    roll({last.t_s, last.camera_mm, last.place_mm, last.sigma_mm, last.height_mm, last.height_sigma_mm},
         flat_velocity, true, speed);
  }
  // The kick was where its line passes the ball's way before; it began before that, as a kicker pushes.
  const Vector2d way = unit_of(flat_velocity);
  constexpr double kMost_s = 0.01, kPushes_s = 0.002;
  const double faster = std::max(300.0, speed - before_mm_s_.dot(way));
  const double late_s = std::clamp((event_mm_ - flat.shot.place_mm).dot(way) / faster, -kMost_s, kMost_s);
  kick_->t_s = event_s_ + late_s - kPushes_s / 2;
  kick_->place_mm = flat.shot.place_mm + way * (speed * late_s) - before_mm_s_ * (kPushes_s / 2);
  const Vector2d kicked = flat_velocity - way * (flat.slides_mm_s2 * late_s);
  kick_->velocity_mm_s << kicked, 0;
  constexpr double kYoung_s = 0.25;
  constexpr std::size_t kFewPoints = 14;
  if (age_s >= kYoung_s || count > kFewPoints) return;
  const double now = std::max(0.0, speed - flat.slides_mm_s2 * (points.back().t_s - event_s_));
  if (now <= speed * model_.rolls_from_share) return;
  flat_.began_mm_s = speed;
  flat_.slides = true;
}

/// A ball that was hidden, and is seen where it may have turned to, is there; its new way is known later.
const BallTrack::Branch* BallTrack::reappears(double t_s) const {
  constexpr double kHidden_s = 0.02, kLong_s = 0.5, kLately_s = 0.06;
  const Branch* out = nullptr;
  for (const Branch& branch : branches_) {
    if (branch.count == 0 || branch.lies()) continue;
    const double last_s = branch.last().t_s;
    if ((last_s - seen_s_ < kHidden_s && !is_announced_) || t_s - last_s > kLately_s) continue;
    // After long, a single sighting is as likely no ball.
    if (last_s - seen_s_ > kLong_s && branch.count < 2) continue;
    if (!out || last_s > out->last().t_s) out = &branch;
  }
  return out;
}

/// False for what no ball does.
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

TrackedBall BallTrack::at(double t_s, const RobotTracks& robots) const {
  constexpr double kShown_s = 0.8;
  TrackedBall out;
  const Branch* branch = reappears(t_s);
  BallState ball{};
  if (branch && where_it_reappears(*branch, t_s, ball)) {
    constexpr double kUnsure = 0.5;
    out.place_mm = ball.place_mm;
    out.velocity_mm_s = ball.velocity_mm_s;
    out.visibility = kUnsure;
    return out;
  }
  out.visibility = std::clamp(1 - (t_s - seen_s_ - 0.03) / kShown_s, 0.0, 1.0);
  if (phase_ == Phase::kFlying) {
    ball = chip_.at(t_s, model_);
    out.place_mm = ball.place_mm;
    out.velocity_mm_s = ball.velocity_mm_s;
    return out;
  }
  Vector2d place, velocity;
  if (phase_ == Phase::kHeld) {
    place = held_at(t_s, robots);
    velocity = Vector2d(0, 0);
    if (const auto robot = robots.at(holder_, t_s))
      velocity = robot->velocity_mm_s + left_of(place - robot->place_mm) * robot->turn_rad_s;
  } else {
    Flat then = flat_;
    then.predict(t_s, model_);
    place = then.place();
    velocity = then.velocity();
    constexpr double kHidden_s = 0.03;
    const Vector2d from = flat_.place(), way = unit_of(place - from);
    const double length = (place - from).norm();
    for (const auto& [name, track] : robots.tracks) {
      if (t_s - seen_s_ <= kHidden_s) break;
      const auto robot = robots.at(name, t_s);
      if (!robot || (from - robot->place_mm).norm() <= kNearlyMm + 0.5) continue;
      // One that is not seen has stopped at a robot in its way.
      const double nearest = std::clamp((robot->place_mm - from).dot(way), 0.0, length);
      if (nearest <= 1 || (from + way * nearest - robot->place_mm).norm() >= kNearlyMm - 6.5) continue;
      place = robot->place_mm + unit_of(from - robot->place_mm) * kNearlyMm;
      velocity = robot->velocity_mm_s;
      break;
    }
  }
  out.place_mm << place, model_.radius_mm;
  out.velocity_mm_s << velocity, 0;
  return out;
}

}  // namespace sslv
