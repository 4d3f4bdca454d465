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

/// Compares tracks with where a simulated field says everything is at the packets' times.
class TrackScorer {
 public:
  /// `world` must outlive this.
  explicit TrackScorer(const SimulatedWorld& world) : world_(world) {}

  /// A packet that came at that Unix time.
  void add(const TrackedFrame& frame, double now_s);

  /// Absolute errors of one kind.
  struct Errors {
    std::vector<float> values;
    double quantile(double share) const;
    double rms() const;
  };
  /// By what they are of: "robot place mm", ... Sorted by their names.
  const std::map<std::string, Errors>& errors() const { return errors_; }

  std::size_t packets() const { return packets_; }
  std::size_t robots_expected() const { return robots_expected_; }  // over all packets
  std::size_t robots_missing() const { return robots_missing_; }
  std::size_t ghosts() const { return ghosts_; }  // robots that are not there, and second ones of an id
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

/// Listens to the tracks of a running service whose cameras are simulated, for so long. Throws SettingsError
/// when they are not, or no tracks are sent, or none come.
TrackScorer score_tracks(const Config& config, const SimulatedWorld& world, double seconds);
/// The field that the cameras of these settings see. Throws SettingsError when they do not see the same.
SimulatedWorld simulated_world(const Config& config);

Json track_score_json(const TrackScorer& scorer);
/// A table for people.
std::string track_score_text(const TrackScorer& scorer);

}  // namespace sslv
