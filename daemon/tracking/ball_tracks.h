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

/// Tracks all candidates for the ball and chooses the ball in play.
class BallTracks {
 public:
  BallTracks();
  void set_model(const BallModel& model);
  const BallModel& model() const { return model_; }
  /// Processes the balls of one image.
  void add(const std::vector<BallObservation>& all, const RobotTracks& robots);

  /// The ball in play; nothing while it is unknown.
  std::optional<TrackedBall> played_at(double t_s, const RobotTracks& robots) const;
  /// Time of the last measurement of the ball in play; nothing while the ball in play is unknown.
  std::optional<double> played_seen_s() const;
  /// Replaces `out` by all certain balls. The ball in play is the first, if it is known.
  void at(double t_s, const RobotTracks& robots, std::vector<TrackedBall>& out) const;
  /// The newest kick.
  const std::optional<TrackedKick>& kick() const { return kick_; }
  /// Number of tracks dropped because their filters were not finite.
  std::uint64_t repaired() const { return repaired_; }

 private:
  struct Ball {
    BallTrack track;
    int number;
    bool is_past = false;  // hypothesis from before a turn
    double began_s = 0;
  };
  /// Whether the track is a ball rather than short-lived clutter. `is_in_doubt` demands more measurements.
  static bool is_sure(const BallTrack& track, double t_s, bool is_in_doubt);
  static bool reaches(const BallTrack& one, const BallTrack& other);
  bool is_of_another(const BallObservation& one, const Ball& ball, const RobotTracks& robots) const;
  void find_played(double t_s);
  void look_for_balls(const std::vector<BallObservation>& seen, const RobotTracks& robots);
  void choose_ball(double t_s, const RobotTracks& robots);
  void take_kick();

  BallModel model_;
  std::vector<Ball> balls_;  // the ball in play first, if is_known_
  bool is_known_ = false;
  double lost_s_ = -1e9;  // last measurement of the previous ball in play
  std::optional<BallTrack> before_;
  std::vector<BallObservation> unexplained_;  // recent measurements that no track explains
  std::vector<BallObservation> seen_;         // measurements of the current image
  std::vector<BallObservation> own_;          // current measurements that may belong to one track
  std::optional<TrackedKick> kick_;
  int numbers_ = 0, kicks_ = 0;
  std::uint64_t repaired_ = 0;
  std::pair<int, int> kick_of_ball_{0, 0};  // number of the ball, number of its kick
};

}  // namespace sslv
