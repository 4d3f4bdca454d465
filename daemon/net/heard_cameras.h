// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/vision_message.h"
#include "tracking/sightings.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// How far another computer's clock is off: its packets say when they were sent, and take hardly any time.
/// Only a clock that is plainly wrong is set right by that; one that is synchronised is better than what a
/// network tells.
class OtherClock {
 public:
  /// A packet that was sent and heard at these Unix times, each by its computer's clock.
  void heard(double t_sent_s, double t_heard_s);
  /// To be added to its times; 0 for a clock that is right.
  double correction_s() const;

 private:
  double since_s_ = 0;                           // by our clock
  double least_now_s_ = 0, least_before_s_ = 0;  // ways, with the difference of the clocks, in two stretches
  bool has_before_ = false, has_now_ = false;
};

/// The cameras of other computers that send to the vision group. All are listed; only those whose computer
/// the settings name are used. Every table forgets what is silent. Not for several threads at once.
class HeardCameras {
 public:
  /// Two visions send a camera with the same id, and tracks could use one of them.
  struct Conflict {
    int camera = 0;
    std::string address;     // of the vision that is not listened to
    std::string instead_of;  // of the one that is
    bool operator==(const Conflict&) const = default;
  };

  /// Ids of this computer's own cameras: others with such an id are left out.
  void set_own(std::set<int> camera_ids) { own_ = std::move(camera_ids); }

  /// A message at a monotonic time and at this computer's Unix time. `is_named`: the settings name its
  /// computer. True if `out` is an image to be used.
  bool hear(const VisionMessage& message, const std::string& address, bool is_named, double now_s,
            double unix_s, ArrivedSightings& out);

  /// Of the last seconds; first those of named computers, which strangers must not hide.
  std::vector<Conflict> conflicts(double now_s) const;
  struct Heard {
    std::string address;
    bool is_used = false;  // for the tracks
    double clock_correction_s = 0;
    std::size_t robots = 0, balls = 0;  // in its newest image
  };
  /// Other computers' cameras that are heard now, by their ids.
  std::map<int, Heard> cameras(double now_s) const;

  /// So long after its last packet, another vision may have the camera's id.
  static constexpr double kForgottenAfter_s = 2;
  /// Geometry comes every minute at the longest.
  static constexpr double kPlaceForgottenAfter_s = 61;

 private:
  using Key = std::pair<std::string, int>;  // address and camera id
  struct Place {                            // where a camera hangs
    Eigen::Vector3d mm;
    double heard_s;  // the camera's last detection or geometry
    bool is_named;
  };
  struct Holder {  // the camera that has an id
    Heard newest;
    double heard_s = 0;
    OtherClock clock;
  };

  void forget(double now_s);
  void note_places(const VisionMessage& message, const std::string& address, bool is_named, double now_s);

  std::set<int> own_;
  std::map<Key, Place> places_;
  std::map<int, Holder> holders_;                         // by camera id
  std::map<Key, std::pair<double, Conflict>> conflicts_;  // each has a place: so strangers' are limited
};

}  // namespace sslv
