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

/// What play tells of a ball: how it slides, rolls and bounces on this carpet.
struct LearntBallModel {
  /// With how sure it is, as kicks differ from each other. Sigma 0: not known.
  struct Value {
    double value = 0, sigma = 0;
    bool is_known() const { return sigma > 0; }
  };
  Value slides_mm_s2, rolls_mm_s2, rolls_from_share;
  Value first_hop_xy, later_hops_xy, hops_z;
  int kicks = 0, chips = 0;  // that it was learnt from
};

/// A kick, and where its ball was seen since.
struct WatchedKick {
  struct Point {
    double t_s;
    Eigen::Vector3d camera_mm;
    Eigen::Vector2d place_mm;  // as if on the floor
  };
  TrackedKick kick;
  std::vector<Point> points;

  static constexpr std::size_t kMaxPoints = 400;
};

/// Watches what becomes of kicks: to be told of every image. Allocates nothing in steady state.
class KickWatch {
 public:
  KickWatch() { now_.points.reserve(WatchedKick::kMaxPoints); }

  /// The kick that is over, and worth learning from; null while there is none. Valid until the next call.
  const WatchedKick* add(const Observations& seen, const TrackedField& tracked);

 private:
  bool is_watching_ = false;
  WatchedKick now_;
  double seen_s_ = 0, noted_s_ = 0;
  int last_number_ = 0;
};

/// Learns from kicks whose ball goes on undisturbed for a while. Each is fitted for its own, with the ball's
/// model among what is fitted; what most kicks say counts.
class BallModelLearner {
 public:
  /// `model`: from which the fit begins. Takes some milliseconds.
  void learn(const WatchedKick& watched, const BallModel& model);

  const LearntBallModel& learnt() const { return learnt_; }

 private:
  /// What one kick says of a number, and how sure.
  struct Said {
    double value, sigma;
  };
  /// The newest, of which the oldest goes.
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
