// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "capture/simulator/simulator_world.h"
#include "config/config.h"
#include "ssl_vision_wrapper_tracked.pb.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Compares tracks with the true state of a simulated field at the packets' times.
class TrackScorer {
 public:
  /// `world` must outlive this.
  explicit TrackScorer(const SimulatedWorld& world) : world_(world) {}

  /// Adds a packet that arrived at the Unix time `now_s`.
  void add(const TrackedFrame& frame, double now_s);

  /// Absolute errors of one kind.
  struct Errors {
    std::vector<float> values;
    double quantile(double share) const;
    double rms() const;
  };
  /// Errors by kind, sorted by name: "robot's place mm", ...
  const std::map<std::string, Errors>& errors() const { return errors_; }

  std::size_t packets() const { return packets_; }
  std::size_t robots_expected() const { return robots_expected_; }  // over all packets
  std::size_t robots_missing() const { return robots_missing_; }
  std::size_t ghosts() const { return ghosts_; }  // robots that do not exist, and repeated ids
  std::size_t balls_missing() const { return balls_missing_; }
  std::size_t balls_wrong() const { return balls_wrong_; }  // more than 300 mm off

 private:
  using Key = std::pair<int, int>;  // team, id

  const SimulatedWorld& world_;
  std::map<std::string, Errors> errors_;
  std::map<Key, Eigen::Vector2d> last_error_mm_;
  std::size_t packets_ = 0, robots_expected_ = 0, robots_missing_ = 0, ghosts_ = 0, balls_missing_ = 0,
              balls_wrong_ = 0;
};

/// Receives the tracks of a running service with simulated cameras for `seconds`. Throws SettingsError if it
/// sends no tracks, if they cannot be received, or if none arrive.
TrackScorer score_tracks(const Config& config, const SimulatedWorld& world, double seconds);
/// The world of the first simulated camera in these settings; the other cameras must have the same
/// options, which is not checked. Throws SettingsError if no camera is simulated.
SimulatedWorld simulated_world(const Config& config);

Json track_score_json(const TrackScorer& scorer);
/// A human-readable table.
std::string track_score_text(const TrackScorer& scorer);

}  // namespace sslv
