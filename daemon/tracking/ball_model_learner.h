// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_motion.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Ball dynamics on this carpet (sliding, rolling, bouncing), learnt from kicks in play.
struct LearntBallModel {
  /// The sigma is derived from the spread between kicks; 0: unknown.
  struct Value {
    double value = 0, sigma = 0;
    bool is_known() const { return sigma > 0; }
  };
  Value slides_mm_s2, rolls_mm_s2, rolls_from_share;
  Value first_hop_xy, later_hops_xy, hops_z;
  int kicks = 0, chips = 0;  // numbers of flat kicks and chips used for learning
};

/// A kick and the later measurements of its ball.
struct WatchedKick {
  struct Point {
    double t_s;
    Eigen::Vector3d camera_mm;
    Eigen::Vector2d place_mm;  // projected onto the floor (z = ball radius)
  };
  TrackedKick kick;
  std::vector<Point> points;

  static constexpr std::size_t kMaxPoints = 400;
};

/// Collects the measurements after a kick. add() must be called for every image. Allocates nothing in steady
/// state.
class KickWatch {
 public:
  KickWatch() { now_.points.reserve(WatchedKick::kMaxPoints); }

  /// Returns a finished kick with enough points to learn from, or null. Valid until the next call.
  const WatchedKick* add(const Observations& seen, const TrackedField& tracked);

 private:
  bool is_watching_ = false;
  WatchedKick now_;
  double seen_s_ = 0, noted_s_ = 0;
  int last_number_ = 0;
};

/// Learns the ball dynamics from kicks whose ball moves undisturbed for a while. Each kick is fitted
/// separately, with the ball model among the parameters; estimates far from the majority are ignored.
class BallModelLearner {
 public:
  /// `model`: start of the fit and centre of its priors. Takes a few milliseconds.
  void learn(const WatchedKick& watched, const BallModel& model);

  const LearntBallModel& learnt() const { return learnt_; }

 private:
  /// One kick's estimate of a parameter.
  struct Said {
    double value, sigma;
  };
  /// The newest kMax estimates.
  class Sayings {
   public:
    void add(const Said& said);
    LearntBallModel::Value value() const;

   private:
    static constexpr std::size_t kMax = 60;
    std::vector<Said> all_;
    std::size_t next_ = 0;
  };

  void learn_flat(const WatchedKick& watched, const BallModel& model);
  void learn_chip(const WatchedKick& watched, const BallModel& model);

  std::array<Sayings, 6> said_;  // in the order of LearntBallModel
  LearntBallModel learnt_;
};

}  // namespace sslv
