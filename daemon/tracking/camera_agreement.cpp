// SPDX-License-Identifier: Apache-2.0
#include "tracking/camera_agreement.h"

#include "geometry/limits.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sslv {

using Eigen::Vector2d;

namespace {

/// Prior sigmas of calibration errors, clock offsets and robots' heights.
constexpr double kErrorMm = 1.4, kOffset_s = 0.5e-3, kHeightMm = 4.5;
/// Variance of a difference between two cameras: errors that are not quadratic, and robots that turn between
/// the two images.
constexpr double kDifferenceVarMm2 = 1.5;
constexpr double kSurprise = 25;

}  // namespace

int CameraAgreement::add_states(int count) {
  const auto at = static_cast<int>(states_.size());
  states_.conservativeResize(at + count);
  states_.tail(count).setZero();
  taken_off_.conservativeResize(at + count);
  taken_off_.tail(count).setZero();
  cov_.conservativeResize(at + count, at + count);
  cov_.rightCols(count).setZero();
  cov_.bottomRows(count).setZero();
  return at;
}

void CameraAgreement::forget(const Camera& camera, double error_mm) {
  states_.segment(camera.at, kPerCamera).setZero();
  cov_.middleRows(camera.at, kPerCamera).setZero();
  cov_.middleCols(camera.at, kPerCamera).setZero();
  cov_.diagonal().segment(camera.at, 2 * kTerms).setConstant(error_mm * error_mm);
  cov_(camera.at + 2 * kTerms, camera.at + 2 * kTerms) = kOffset_s * kOffset_s;
}

/// Index of a new camera's first state; none if the maximum number of cameras is reached. The maximum exists
/// because the cost grows with the square of the number of cameras. A new camera replaces the other
/// computers' camera that has been silent for longest.
std::optional<int> CameraAgreement::place_for_camera() {
  if (cameras_.size() < limits::kMaxCameras) return add_states(kPerCamera);
  auto silent = cameras_.end();
  for (auto one = cameras_.begin(); one != cameras_.end(); ++one) {
    if (!one->second.is_of_other_computer) continue;
    if (silent == cameras_.end() || one->second.heard < silent->second.heard) silent = one;
  }
  if (silent == cameras_.end()) return {};
  const int at = silent->second.at;
  taken_off_.segment(at, kPerCamera).setZero();
  forget_sightings(silent->first);
  cameras_.erase(silent);
  return at;
}

/// Forgets the camera's earlier measurements, which must not be compared with later measurements.
void CameraAgreement::forget_sightings(int camera) {
  std::erase_if(differences_,
                [&](const auto& one) { return one.first.camera == camera || one.first.other == camera; });
  const auto is_of = [&](const auto& one) { return one.first.first == camera || one.first.second == camera; };
  std::erase_if(surprises_, is_of);
  std::erase_if(overlaps_, is_of);
  for (auto& [name, track] : tracks_) track.by_camera.erase(camera);
}

void CameraAgreement::set_camera(int camera, const Eigen::Vector3d& center_mm, bool is_of_other_computer) {
  const auto known = cameras_.find(camera);
  ++heard_;
  if (known != cameras_.end() && known->second.center_mm == center_mm &&
      known->second.is_of_other_computer == is_of_other_computer) {
    known->second.heard = heard_;
    return;
  }
  const auto at = known != cameras_.end() ? std::optional(known->second.at) : place_for_camera();
  if (!at) return;
  const Camera made{center_mm, *at, is_of_other_computer, heard_};
  cameras_.insert_or_assign(camera, made);
  forget(made, kErrorMm);
  forget_sightings(camera);
}

void CameraAgreement::set_evenness(int camera, double share) {
  if (const auto known = cameras_.find(camera); known != cameras_.end()) known->second.evenness = share;
}

double CameraAgreement::evenness_of(int camera) const {
  const auto known = cameras_.find(camera);
  return known == cameras_.end() ? 0 : known->second.evenness;
}

Eigen::Matrix<double, CameraAgreement::kTerms, 1> CameraAgreement::terms(const Camera& camera,
                                                                         const Vector2d& place_mm) const {
  const double reach_mm = 0.6 * camera.center_mm.z();
  const Vector2d q = (place_mm - camera.center_mm.head<2>()) / reach_mm;
  Eigen::Matrix<double, kTerms, 1> out;
  out << 1, q.x(), q.y(), q.x() * q.x(), q.x() * q.y(), q.y() * q.y();
  return out;
}

/// Shift of a robot's measured position, away from the camera, per millimetre of its height (mm/mm).
Vector2d CameraAgreement::outwards(const Camera& camera, const Vector2d& place_mm, double height_mm) const {
  const double above_mm = std::max(limits::kMinAboveRobotMm, camera.center_mm.z() - height_mm);
  return (place_mm - camera.center_mm.head<2>()) / above_mm;
}

/// Finds or adds a robot; null if the maximum number of robots is reached. Robots seen only by other
/// computers use at most half of the entries and never replace a robot seen by our cameras.
CameraAgreement::Track* CameraAgreement::track_of(const RobotName& robot, double t_s, bool is_of_other) {
  const auto known = tracks_.find(robot);
  if (known != tracks_.end()) return &known->second;
  int at = 0;
  if (tracks_.size() < (is_of_other ? limits::kMaxRobots / 2 : limits::kMaxRobots)) {
    at = add_states(1);
  } else {
    const auto oldest = std::ranges::min_element(tracks_, {}, [&](const auto& one) {
      return std::pair(is_of_other && one.second.is_ours, one.second.seen_s);
    });
    const double gone_s = is_of_other ? 60 : 0.5;
    if (is_of_other && oldest->second.is_ours) return nullptr;
    if (std::abs(t_s - oldest->second.seen_s) < gone_s) return nullptr;
    at = oldest->second.at;
    tracks_.erase(oldest);
    states_[at] = taken_off_[at] = 0;
    cov_.row(at).setZero();
    cov_.col(at).setZero();
  }
  cov_(at, at) = kHeightMm * kHeightMm;
  return &tracks_.emplace(robot, Track{.at = at, .by_camera = {}}).first->second;
}

void CameraAgreement::see(int camera, const Seen& seen) {
  const auto here = cameras_.find(camera);
  if (here == cameras_.end()) return;
  const bool is_of_other = here->second.is_of_other_computer;
  Track* const known = track_of(seen.robot, seen.t_s, is_of_other);
  if (!known) return;
  Track& track = *known;
  track.seen_s = seen.t_s;
  track.is_ours = track.is_ours || !is_of_other;
  auto& [before, now] = track.by_camera[camera];
  before = now;
  now = {seen.place_mm, seen.t_s};
  const double passed_s = now.t_s - before.t_s;
  constexpr double kNext_s = 0.12;
  if (track.by_camera.size() < 2 || passed_s <= 0 || passed_s > kNext_s) return;
  // The estimates change slowly: after kAtFirst comparisons, one per kEvery_s is enough. Comparisons with
  // other computers' cameras are limited separately from comparisons between our cameras.
  const auto is_due = [&](const Compared& last) {
    constexpr int kAtFirst = 300;
    constexpr double kEvery_s = 0.05;
    return last.count <= kAtFirst || seen.t_s < last.t_s || seen.t_s - last.t_s >= kEvery_s;
  };
  const std::array is_due_now{is_due(track.compared[0]), is_due(track.compared[1])};
  if (!is_due_now[0] && !is_due_now[1]) return;
  const Vector2d velocity = (now.place_mm - before.place_mm) / passed_s;
  for (const auto& [other_camera, lasts] : track.by_camera) {
    const Last& other = lasts.second;
    if (other_camera == camera || other.t_s <= before.t_s || other.t_s >= now.t_s) continue;
    const std::size_t which = is_of_other || cameras_.at(other_camera).is_of_other_computer ? 1 : 0;
    if (!is_due_now[which]) continue;
    const Vector2d place = before.place_mm + velocity * (other.t_s - before.t_s);
    if (!compare({camera, other_camera, place, other.place_mm, velocity, passed_s, seen.height_mm, other.t_s},
                 track))
      return;
    track.compared[which].t_s = seen.t_s;
    ++track.compared[which].count;
  }
}

/// Returns false if the filter was not finite and was reset.
bool CameraAgreement::compare(const Pair& pair, const Track& track) {
  const Camera &a = cameras_.at(pair.a), &b = cameras_.at(pair.b);
  // A camera cannot see the top of a robot that is as high as the camera.
  if (std::min(a.center_mm.z(), b.center_mm.z()) < pair.height_mm + limits::kMinAboveRobotMm) return true;
  // The same place for both cameras: otherwise errors common to both, which would move all robots closer
  // together, would explain the difference.
  const Vector2d place = (pair.place_a_mm + pair.place_b_mm) / 2;
  const auto terms_a = terms(a, place), terms_b = terms(b, place);
  const Vector2d higher = outwards(a, place, pair.height_mm) - outwards(b, place, pair.height_mm);
  const Vector2d apart = pair.place_a_mm - pair.place_b_mm;
  /// Larger distances mean two robots, one of them misread.
  constexpr double kSameRobotMm = 150;
  if (!(apart.norm() <= kSameRobotMm)) return true;
  const double ahead_s = states_[a.at + 2 * kTerms] - states_[b.at + 2 * kTerms];
  // Only height differences between robots count: a height error common to all robots may equally be an error
  // of the cameras.
  double common_mm = 0;
  for (const auto& [name, one] : tracks_) common_mm += states_[one.at] / static_cast<double>(tracks_.size());
  const Vector2d at_once = apart + pair.velocity_mm_s * ahead_s;
  note_difference(pair, at_once - higher * (states_[track.at] - common_mm), at_once,
                  higher * states_[track.at]);
  // Interpolation error if the robot accelerated between the two images.
  constexpr double kAcceleration_mm_s2 = 4000;
  const double swerves_mm = kAcceleration_mm_s2 * pair.passed_s * pair.passed_s / 8;
  bool is_surprise = false;
  for (int axis = 0; axis < 2; ++axis) {
    row_.clear();
    for (int i = 0; i < kTerms; ++i) {
      row_.emplace_back(a.at + axis * kTerms + i, terms_a[i]);
      row_.emplace_back(b.at + axis * kTerms + i, -terms_b[i]);
    }
    // For a given time, a camera whose clock is ahead reports an earlier position of the robot.
    row_.emplace_back(a.at + 2 * kTerms, -pair.velocity_mm_s[axis]);
    row_.emplace_back(b.at + 2 * kTerms, pair.velocity_mm_s[axis]);
    row_.emplace_back(track.at, higher[axis]);
    double expected = 0, variance = kDifferenceVarMm2 + swerves_mm * swerves_mm;
    gain_.setZero(states_.size());
    for (const auto& [at, weight] : row_) {
      gain_ += weight * cov_.col(at);
      expected += weight * states_[at];
    }
    for (const auto& [at, weight] : row_) variance += weight * gain_[at];
    const double off = apart[axis] - expected;
    if (!std::isfinite(off) || !std::isfinite(variance) || variance <= 0) {
      begin_again();
      return false;
    }
    if (off * off > kSurprise * variance) {
      is_surprise = true;
      continue;
    }
    // Our cameras' uncertainty adds to the variance, but other computers' cameras do not correct our cameras.
    if (a.is_of_other_computer || b.is_of_other_computer) keep_own();
    states_ += gain_ * (off / variance);
    cov_.noalias() -= gain_ * gain_.transpose() / variance;
  }
  // Single outliers are misread robots. Repeated outliers mean that a camera was bumped, so its estimates are
  // no longer valid.
  constexpr int kBumped = 60;
  int& surprises = surprises_[std::minmax(pair.a, pair.b)];
  surprises = is_surprise ? surprises + 1 : std::max(0, surprises - 3);
  if (surprises < kBumped) return true;
  surprises = 0;
  // If only one of the two cameras belongs to another computer, reset only that camera.
  const double error_mm = std::max(kErrorMm, apart.norm());
  if (a.is_of_other_computer || !b.is_of_other_computer) forget(a, error_mm);
  if (b.is_of_other_computer || !a.is_of_other_computer) forget(b, error_mm);
  std::erase_if(differences_, [&](const auto& one) {
    return one.first.camera == std::min(pair.a, pair.b) && one.first.other == std::max(pair.a, pair.b);
  });
  return true;
}

/// Zeroes the gain of the states of our cameras and of the robots' heights, so that these states never
/// correlate with those of other computers' cameras.
void CameraAgreement::keep_own() {
  for (const auto& [id, camera] : cameras_) {
    if (!camera.is_of_other_computer) gain_.segment(camera.at, kPerCamera).setZero();
  }
  for (const auto& [name, track] : tracks_) gain_[track.at] = 0;
}

void CameraAgreement::begin_again() {
  const std::uint64_t repaired = repaired_ + 1;
  *this = {};
  repaired_ = repaired;
}

void CameraAgreement::note_difference(const Pair& pair, const Vector2d& off_mm, const Vector2d& apart_mm,
                                      const Vector2d& of_height_mm) {
  // Enough for a field of 16 x 16 m. Other computers' cameras use at most half of these parts.
  constexpr std::size_t kMaxParts = 1024;
  constexpr double kRemembers = 100;  // samples
  const bool is_swapped = pair.b < pair.a;
  const Vector2d place = pair.place_a_mm / kPartMm;
  const PartKey key{std::min(pair.a, pair.b), std::max(pair.a, pair.b),
                    static_cast<int>(std::floor(place.x())), static_cast<int>(std::floor(place.y()))};
  auto known = differences_.find(key);
  if (known == differences_.end()) {
    const bool is_of_other =
        cameras_.at(pair.a).is_of_other_computer || cameras_.at(pair.b).is_of_other_computer;
    if (differences_.size() >= (is_of_other ? kMaxParts / 2 : kMaxParts)) return;
    const Vector2d middle((key.column + 0.5) * kPartMm, (key.row + 0.5) * kPartMm);
    known = differences_.emplace(key, Difference{key.camera, key.other, middle}).first;
  }
  Difference& one = known->second;
  one.samples = std::min(one.samples + 1, kRemembers);
  const Vector2d off = is_swapped ? Vector2d(-off_mm) : off_mm;
  one.off_mm += (off - one.off_mm) / one.samples;
  one.t_s = pair.t_s;
  constexpr double kSure = 5, kForgets = 0.01;
  if (one.samples < kSure) return;
  Overlap& overlap = overlaps_[{key.camera, key.other}];
  const Vector2d here = (pair.place_a_mm + pair.place_b_mm) / 2;
  overlap.parts.extend(here);
  // The estimates are from earlier comparisons, so this one can tell whether they are of use.
  const Vector2d corrected = apart_mm - of_height_mm - estimate_of(cameras_.at(pair.a), here) +
                             estimate_of(cameras_.at(pair.b), here);
  overlap.corrected_mm2 += kForgets * (corrected.squaredNorm() - overlap.corrected_mm2);
  overlap.uncorrected_mm2 += kForgets * (apart_mm.squaredNorm() - overlap.uncorrected_mm2);
  const double differs_mm = one.off_mm.norm();
  overlap.differs_mm =
      std::max(differs_mm, overlap.differs_mm + kForgets * (differs_mm - overlap.differs_mm));
}

void CameraAgreement::forget_differences(double before_s) {
  std::erase_if(differences_, [&](const auto& one) { return one.second.t_s < before_s; });
}

void CameraAgreement::follow(double passed_s) {
  constexpr double kFollows_s = 0.4;
  taken_off_ += (states_ - taken_off_) * (1 - std::exp(-passed_s / kFollows_s));
  // Mounts warm up, clocks drift, and a robot may be replaced by another with its id. So within this time the
  // estimates become as uncertain as they were initially.
  constexpr double kForgets_s = 600;
  const double share = std::clamp(passed_s, 0.0, 1.0) / kForgets_s;
  const auto forget_some = [&](int first, int count, double sigma) {
    for (int i = first; i < first + count; ++i) {
      if (cov_(i, i) < sigma * sigma) cov_(i, i) += share * sigma * sigma;
    }
  };
  for (const auto& [id, camera] : cameras_) {
    // What no difference shows returns to zero.
    states_.segment(camera.at, kPerCamera) *= 1 - share;
    forget_some(camera.at, 2 * kTerms, kErrorMm);
    forget_some(camera.at + 2 * kTerms, 1, kOffset_s);
  }
  for (const auto& [name, track] : tracks_) forget_some(track.at, 1, kHeightMm);
}

Vector2d CameraAgreement::estimate_of(const Camera& camera, const Vector2d& place_mm) const {
  const auto at = terms(camera, place_mm);
  return {taken_off_.segment<kTerms>(camera.at).dot(at),
          taken_off_.segment<kTerms>(camera.at + kTerms).dot(at)};
}

/// Small errors are corrected as estimated. If cameras differ much, the estimates hold only for differences:
/// these are shared between the cameras that see a place, so that the errors that all cameras have in common
/// stay as they are. Where only one camera sees robots, nothing confirms the estimates, so corrections are
/// small.
Vector2d CameraAgreement::error_of(int camera, const Vector2d& place_mm) const {
  constexpr double kFadesMm = 700, kFarMm = 3.5, kMore = 1.5, kSmallMm = 12;
  const auto here = cameras_.find(camera);
  if (here == cameras_.end()) return {0, 0};
  const auto at_most = [](const Vector2d& error, double most_mm) -> Vector2d {
    const double length = error.norm();
    return length <= most_mm ? error : Vector2d(error * (most_mm / length));
  };
  const bool is_of_other = here->second.is_of_other_computer;
  const Vector2d own = estimate_of(here->second, place_mm);
  Vector2d shared(0, 0), from_ours(0, 0);  // sums, by the weights of the other cameras
  double sharing = 1, ours = 0, nearest = 0, differs_mm = 0;
  bool is_confirmed = false;
  for (const auto& [pair, overlap] : overlaps_) {
    if (pair.first != camera && pair.second != camera) continue;
    const int other = pair.first == camera ? pair.second : pair.first;
    const Camera& there = cameras_.at(other);
    // Other computers' cameras do not correct ours.
    if ((there.is_of_other_computer && !is_of_other) || overlap.corrected_mm2 > overlap.uncorrected_mm2)
      continue;
    is_confirmed = true;
    const double away = overlap.parts.exteriorDistance(place_mm) / kFadesMm, weight = std::exp(-away * away);
    const Vector2d apart = at_most(own - estimate_of(there, place_mm), kMore * overlap.differs_mm + kFarMm);
    nearest = std::max(nearest, weight);
    differs_mm = std::max(differs_mm, weight * overlap.differs_mm);
    if (is_of_other && !there.is_of_other_computer) {
      from_ours += weight * (apart + error_of(other, place_mm));
      ours += weight;
    } else {
      shared += weight * apart;
      sharing += weight;
    }
  }
  if (!is_confirmed) return {0, 0};
  const Vector2d near = ours > 0 ? Vector2d(from_ours * (nearest / ours)) : Vector2d(shared / sharing);
  const Vector2d far = at_most(own, kFarMm), all = at_most(own, kFarMm + differs_mm);
  const double much = std::clamp(differs_mm / kSmallMm - 1, 0.0, 1.0);
  return (1 - much) * all + much * (near + (1 - nearest) * far);
}

Vector2d CameraAgreement::height_error_of(int camera, const RobotName& robot, const Vector2d& place_mm,
                                          double height_mm) const {
  const auto here = cameras_.find(camera);
  const auto known = tracks_.find(robot);
  if (here == cameras_.end() || known == tracks_.end()) return {0, 0};
  // A larger height is another error.
  constexpr double kMaxMm = 15;
  return std::clamp(taken_off_[known->second.at], -kMaxMm, kMaxMm) *
         outwards(here->second, place_mm, height_mm);
}

double CameraAgreement::time_offset_s(int camera) const {
  const auto here = cameras_.find(camera);
  return here == cameras_.end() ? 0 : taken_off_[here->second.at + 2 * kTerms];
}

std::optional<CameraAgreement::Height> CameraAgreement::height_of(const RobotName& robot) const {
  const auto known = tracks_.find(robot);
  if (known == tracks_.end()) return {};
  const int at = known->second.at;
  return Height{states_[at], std::sqrt(cov_(at, at))};
}

}  // namespace sslv
