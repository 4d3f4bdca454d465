// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/ball_motion.h"
#include "tracking/ball_track.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace sslv {

/// All that may be the ball, of which one is played.
class BallTracks {
 public:
  BallTracks();
  void set_model(const BallModel& model);
  const BallModel& model() const { return model_; }
  /// The balls of one image.
  void add(const std::vector<BallObservation>& all, const RobotTracks& robots);

  /// The one that is played; nothing while it may be anywhere.
  std::optional<TrackedBall> played_at(double t_s, const RobotTracks& robots) const;
  /// When a camera saw that one last.
  std::optional<double> played_seen_s() const;
  /// Makes `out` all of them, the one that is played first, while that is known.
  void at(double t_s, const RobotTracks& robots, std::vector<TrackedBall>& out) const;
  /// The newest.
  const std::optional<TrackedKick>& kick() const { return kick_; }
  /// Balls that were dropped because their filters were not finite.
  std::uint64_t repaired() const { return repaired_; }

 private:
  struct Ball {
    BallTrack track;
    int number;
    bool is_past = false;  // what one was before it turned
    double began_s = 0;
  };
  /// Whether it is more than something that looks like a ball for some images.
  static bool is_sure(const BallTrack& track, double t_s, bool is_in_doubt);
  static bool reaches(const BallTrack& one, const BallTrack& other);
  bool is_of_another(const BallObservation& one, const Ball& ball, const RobotTracks& robots) const;
  void find_played(double t_s);
  void look_for_balls(const std::vector<BallObservation>& seen, const RobotTracks& robots);
  void choose_ball(double t_s, const RobotTracks& robots);
  void take_kick();

  BallModel model_;
  std::vector<Ball> balls_;  // the one that is played first, while that is known
  bool is_known_ = false;
  double lost_s_ = -1e9;  // when the one that was played was seen last
  std::optional<BallTrack> before_;
  std::vector<BallObservation> unexplained_;  // lately
  std::vector<BallObservation> seen_;         // in this image
  std::vector<BallObservation> own_;          // what one of them may be
  std::optional<TrackedKick> kick_;
  int numbers_ = 0, kicks_ = 0;
  std::uint64_t repaired_ = 0;
  std::pair<int, int> kick_of_ball_{0, 0};  // the ball's number, its kick's
};

}  // namespace sslv
