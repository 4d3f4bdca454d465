// SPDX-License-Identifier: Apache-2.0
#include "tracking/ball_model_learner.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Dense>

namespace sslv {

using Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d, Eigen::VectorXd;

namespace {

/// Longest time that a ball is watched, and shortest times for learning from a flat kick and from a chip.
constexpr double kLongestKick_s = 4, kShortestFlat_s = 0.8, kShortestChip_s = 0.5;
constexpr double kGap_s = 0.3;
constexpr std::size_t kMinPoints = 40;
constexpr double kRadiusMm = 21.5;  // only for associating measurements: need not be exact
/// Measurements farther from the tracked ball belong to another ball.
constexpr double kOwnMm = 60;
/// Residual calibration errors vary slowly along the trajectory, so the errors of neighbouring measurements
/// are correlated. This increased sigma accounts for the correlation.
constexpr double kSightingSigmaMm = 3;
/// A larger residual means that the ball hit something.
constexpr double kMetSomethingMm = 12;
/// An estimate is used if its sigma is at most this share of the value.
constexpr double kUsefulShare = 0.25;
constexpr std::size_t kEnoughSaid = 3;

/// A ball's position projected from a camera onto the floor plane (z = ball radius).
Vector2d seen_from(const Vector3d& camera_mm, const Vector3d& place_mm, double radius_mm) {
  const double share = (camera_mm.z() - radius_mm) / std::max(1.0, camera_mm.z() - place_mm.z());
  return camera_mm.head<2>() + (place_mm.head<2>() - camera_mm.head<2>()) * share;
}

/// Parameters of a fit. Their order in a vector: position, velocity (3D for a chip), time (chip only), model.
struct Numbers {
  BallShot shot;
  BallModel model;
};

struct Fit {
  VectorXd values, sigmas;
  double worst_mm = 0;  // largest absolute residual
  bool is_good = false;
};

/// Levenberg-Marquardt with finite differences of size `steps`. `to_numbers` converts a parameter vector;
/// `priors`: sigmas of the priors, which are centred on `start`.
template <class Points, class ToNumbers>
Fit fit(const Points& points, const VectorXd& start, const VectorXd& steps, const VectorXd& priors,
        const ToNumbers& to_numbers) {
  constexpr int kIterations = 12;
  const auto count = static_cast<Eigen::Index>(points.size());
  const auto residuals_of = [&](const VectorXd& values) {
    const Numbers numbers = to_numbers(values);
    VectorXd out(2 * count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto& point = points[static_cast<std::size_t>(i)];
      const BallState state = numbers.shot.at(point.t_s, numbers.model);
      out.segment<2>(2 * i) =
          point.place_mm - seen_from(point.camera_mm, state.place_mm, numbers.model.radius_mm);
    }
    return out;
  };
  const double weight = 1 / (kSightingSigmaMm * kSightingSigmaMm);
  Fit out;
  out.values = start;
  VectorXd residuals = residuals_of(out.values);
  double damping = 1e-3;
  MatrixXd normal;
  const auto cost_of = [&](const VectorXd& values, const VectorXd& of) {
    return weight * of.squaredNorm() + ((values - start).cwiseQuotient(priors)).squaredNorm();
  };
  double cost = cost_of(out.values, residuals);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    MatrixXd by_values(residuals.size(), start.size());
    for (Eigen::Index k = 0; k < start.size(); ++k) {
      VectorXd aside = out.values;
      aside[k] += steps[k];
      by_values.col(k) = (residuals_of(aside) - residuals) / steps[k];
    }
    normal = weight * by_values.transpose() * by_values;
    normal.diagonal() += priors.cwiseAbs2().cwiseInverse();
    const VectorXd gradient = -weight * (by_values.transpose() * residuals) -
                              (out.values - start).cwiseQuotient(priors.cwiseAbs2());
    bool is_better = false;
    for (int tries = 0; tries < 6 && !is_better; ++tries) {
      MatrixXd damped = normal;
      damped.diagonal() *= 1 + damping;
      const VectorXd next = out.values + damped.ldlt().solve(gradient);
      const VectorXd left = residuals_of(next);
      const double next_cost = cost_of(next, left);
      is_better = next_cost < cost;
      damping *= is_better ? 0.2 : 5;
      if (!is_better) continue;
      const bool is_done = cost - next_cost < 1e-6 * cost;
      out.values = next;
      residuals = left;
      cost = next_cost;
      if (is_done) iteration = kIterations;
    }
    if (!is_better) break;
  }
  const MatrixXd cov = normal.inverse();
  out.sigmas = cov.diagonal().cwiseMax(0).cwiseSqrt();
  out.worst_mm = residuals.cwiseAbs().maxCoeff();
  out.is_good = out.values.allFinite() && out.worst_mm < kMetSomethingMm;
  return out;
}

}  // namespace

void BallModelLearner::Sayings::add(const Said& said) {
  if (!std::isfinite(said.value) || !(said.sigma > 0) || said.sigma > kUsefulShare * std::abs(said.value))
    return;
  if (all_.size() < kMax) {
    all_.push_back(said);
  } else {
    all_[next_] = said;
    next_ = (next_ + 1) % kMax;
  }
}

/// Mean of the estimates near the weighted median, which is not shifted by outliers (kicks whose ball hit
/// something unnoticed). The sigma is derived from the spread between kicks.
LearntBallModel::Value BallModelLearner::Sayings::value() const {
  if (all_.size() < kEnoughSaid) return {};
  std::vector<Said> sorted = all_;
  std::sort(sorted.begin(), sorted.end(), [](const Said& a, const Said& b) { return a.value < b.value; });
  const auto weight_of = [](const Said& one) { return 1 / (one.sigma * one.sigma); };
  double total = 0;
  for (const Said& one : sorted) total += weight_of(one);
  double median = sorted.back().value, passed = 0;
  for (const Said& one : sorted) {
    passed += weight_of(one);
    if (passed < total / 2) continue;
    median = one.value;
    break;
  }
  // The mean of the estimates near the median is more accurate than the median.
  constexpr double kNear = 3;
  std::vector<double> apart;
  for (const Said& one : sorted) apart.push_back(std::abs(one.value - median));
  std::nth_element(apart.begin(), apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2), apart.end());
  const double spread = std::max(1.48 * apart[apart.size() / 2], 1e-3 * std::abs(median));
  double sum = 0, weights = 0, squares = 0;
  int count = 0;
  for (const Said& one : sorted) {
    if (std::abs(one.value - median) > kNear * std::max(spread, one.sigma)) continue;
    const double weight = 1 / (one.sigma * one.sigma + spread * spread);
    sum += weight * one.value;
    weights += weight;
    ++count;
  }
  const double mean = sum / weights;
  for (const Said& one : sorted) {
    if (std::abs(one.value - median) > kNear * std::max(spread, one.sigma)) continue;
    squares += (one.value - mean) * (one.value - mean);
  }
  const double by_spread = std::sqrt(squares / std::max(1, count - 1) / count);
  return {mean, std::max(by_spread, std::sqrt(1 / weights) / 4)};
}

const WatchedKick* KickWatch::add(const Observations& seen, const TrackedField& tracked) {
  const bool has_ball = !tracked.balls.empty();
  const bool is_same = is_watching_ && tracked.kick && tracked.kick->number == now_.kick.number;
  const WatchedKick* over = nullptr;
  if (is_watching_ &&
      (!is_same || !has_ball || tracked.t_s - seen_s_ > kGap_s ||
       tracked.t_s - now_.kick.t_s > kLongestKick_s || now_.points.size() >= WatchedKick::kMaxPoints)) {
    is_watching_ = false;
    if (now_.points.size() >= kMinPoints) over = &now_;
  } else if (is_same) {
    now_.kick = *tracked.kick;  // the kick's estimate improves with time
  }
  if (over) return over;
  if (!is_watching_) {
    if (!tracked.kick || tracked.kick->number == last_number_ || !has_ball) return nullptr;
    constexpr double kFresh_s = 0.3;
    last_number_ = tracked.kick->number;
    if (tracked.t_s - tracked.kick->t_s > kFresh_s) return nullptr;
    is_watching_ = true;
    now_.kick = *tracked.kick;
    now_.points.clear();
    seen_s_ = tracked.t_s;
    noted_s_ = 0;
  }
  const TrackedBall& ball = tracked.balls.front();
  for (const BallObservation& one : seen.balls) {
    const double passed_s = one.t_s - tracked.t_s;
    const Vector3d then = ball.place_mm + ball.velocity_mm_s * passed_s;
    if ((seen_from(one.camera_mm, then, kRadiusMm) - one.place_mm).norm() > kOwnMm) continue;
    seen_s_ = tracked.t_s;
    constexpr double kAfterTheKick_s = 0.01;  // a kick lasts a few milliseconds
    // Limits the number of points, however many cameras see the ball.
    constexpr double kApart_s = kLongestKick_s / WatchedKick::kMaxPoints;
    if (one.t_s < now_.kick.t_s + kAfterTheKick_s || one.t_s < noted_s_ + kApart_s) continue;
    noted_s_ = one.t_s;
    now_.points.push_back({one.t_s, one.camera_mm, one.place_mm});
  }
  return nullptr;
}

void BallModelLearner::learn(const WatchedKick& watched, const BallModel& model) {
  if (watched.kick.is_chip) {
    learn_chip(watched, model);
  } else {
    learn_flat(watched, model);
  }
  const std::array<LearntBallModel::Value*, 6> values{&learnt_.slides_mm_s2,     &learnt_.rolls_mm_s2,
                                                      &learnt_.rolls_from_share, &learnt_.first_hop_xy,
                                                      &learnt_.later_hops_xy,    &learnt_.hops_z};
  for (std::size_t i = 0; i < values.size(); ++i) *values[i] = said_[i].value();
}

void BallModelLearner::learn_flat(const WatchedKick& watched, const BallModel& model) {
  const TrackedKick& kick = watched.kick;
  // The ball may hit something later: drop points from the end until the fit is good.
  std::size_t count = watched.points.size();
  for (; count >= kMinPoints; count = count * 4 / 5) {
    const std::span<const WatchedKick::Point> points(watched.points.data(), count);
    if (points.back().t_s - points.front().t_s < kShortestFlat_s) return;
    const auto to_numbers = [&](const VectorXd& v) {
      Numbers out{{.t_s = kick.t_s, .place_mm = {v[0], v[1]}, .velocity_mm_s = {v[2], v[3], 0}}, model};
      out.model.slides_mm_s2 = v[4];
      out.model.rolls_mm_s2 = v[5];
      out.model.rolls_from_share = v[6];
      return out;
    };
    VectorXd start(7), steps(7), priors(7);
    start << kick.place_mm, kick.velocity_mm_s.head<2>(), model.slides_mm_s2, model.rolls_mm_s2,
        model.rolls_from_share;
    steps << 0.1, 0.1, 1, 1, 5, 1, 1e-3;
    priors << 50, 50, 500, 500, 2000, 400, 0.2;
    const Fit found = fit(points, start, steps, priors, to_numbers);
    if (!found.is_good) continue;
    // A kick gives no estimate of sliding if the ball was first seen after sliding, and no estimate of
    // rolling if the ball never rolled.
    const std::array<double, 3> prior_sigmas{priors[4], priors[5], priors[6]};
    for (int i = 0; i < 3; ++i) {
      if (found.sigmas[4 + i] < 0.5 * prior_sigmas[static_cast<std::size_t>(i)])
        said_[static_cast<std::size_t>(i)].add({found.values[4 + i], found.sigmas[4 + i]});
    }
    ++learnt_.kicks;
    return;
  }
}

void BallModelLearner::learn_chip(const WatchedKick& watched, const BallModel& model) {
  const TrackedKick& kick = watched.kick;
  std::size_t count = watched.points.size();
  for (; count >= kMinPoints; count = count * 4 / 5) {
    const std::span<const WatchedKick::Point> points(watched.points.data(), count);
    if (points.back().t_s - points.front().t_s < kShortestChip_s) return;
    const auto to_numbers = [&](const VectorXd& v) {
      Numbers out{{.t_s = v[5], .place_mm = {v[0], v[1]}, .velocity_mm_s = {v[2], v[3], v[4]}}, model};
      out.model.first_hop_xy = v[6];
      out.model.later_hops_xy = v[7];
      out.model.hops_z = v[8];
      return out;
    };
    VectorXd start(9), steps(9), priors(9);
    start << kick.place_mm, kick.velocity_mm_s, kick.t_s, model.first_hop_xy, model.later_hops_xy,
        model.hops_z;
    steps << 0.1, 0.1, 1, 1, 1, 1e-5, 1e-3, 1e-3, 1e-3;
    priors << 30, 30, 500, 500, 500, 5e-3, 0.25, 0.15, 0.2;
    const Fit found = fit(points, start, steps, priors, to_numbers);
    if (!found.is_good || found.values[4] <= 0) continue;
    for (int i = 0; i < 3; ++i) {
      if (found.sigmas[6 + i] < 0.5 * priors[6 + i])
        said_[static_cast<std::size_t>(3 + i)].add({found.values[6 + i], found.sigmas[6 + i]});
    }
    ++learnt_.chips;
    return;
  }
}

}  // namespace sslv
