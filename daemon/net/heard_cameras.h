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

/// Estimates the clock offset of another computer from the send times in its packets, assuming a negligible
/// transmission time. Only a plainly wrong clock is corrected: synchronised clocks are more accurate than
/// this estimate.
class OtherClock {
 public:
  /// Adds a packet with its send time and its receive time, in Unix seconds of the respective computer's
  /// clock.
  void heard(double t_sent_s, double t_heard_s);
  /// Seconds to add to the other computer's times; 0 if its clock is right.
  double correction_s() const;

 private:
  double since_s_ = 0;  // start of the current interval, by our clock
  /// Minimum of delay + clock offset, in the current interval and in the previous one.
  double least_now_s_ = 0, least_before_s_ = 0;
  bool has_before_ = false, has_now_ = false;
};

/// The cameras of other computers that send to the vision group. All cameras are listed, but only cameras of
/// computers named in the settings are used. Silent cameras are removed from every table. Not thread-safe.
class HeardCameras {
 public:
  /// Another vision sends a camera with an id that is already used for tracking.
  struct Conflict {
    int camera = 0;
    std::string address;     // address of the ignored vision
    std::string instead_of;  // address of the vision that is used
    bool operator==(const Conflict&) const = default;
  };

  /// Ids of this computer's own cameras; other cameras with these ids are ignored.
  void set_own(std::set<int> camera_ids) { own_ = std::move(camera_ids); }

  /// Processes a message. `now_s`: monotonic receive time; `unix_s`: the same in this computer's Unix time;
  /// `is_named`: the settings name the sender's computer. True if `out` was set to detections for tracking.
  bool hear(const VisionMessage& message, const std::string& address, bool is_named, double now_s,
            double unix_s, ArrivedSightings& out);

  /// The conflicts of the last kForgottenAfter_s. Lists conflicts with named computers first, so that
  /// conflicts with unnamed computers cannot hide them.
  std::vector<Conflict> conflicts(double now_s) const;
  /// Cameras of named computers that cannot be tracked, because their computer's geometry packets lack them,
  /// or are not received at all.
  struct Uncalibrated {
    int camera = 0;
    std::string address;
    bool operator==(const Uncalibrated&) const = default;
  };
  std::vector<Uncalibrated> uncalibrated(double now_s) const;
  struct Heard {
    std::string address;
    bool is_used = false;  // used for tracking
    double clock_correction_s = 0;
    std::size_t robots = 0, balls = 0;  // counts in the camera's newest frame
  };
  /// Other computers' cameras that are currently received, by id.
  std::map<int, Heard> cameras(double now_s) const;

  /// After this time without a packet, another vision may take over the camera's id.
  static constexpr double kForgottenAfter_s = 2;
  /// The interval of geometry packets is at most a minute.
  static constexpr double kPlaceForgottenAfter_s = 61;

 private:
  using Key = std::pair<std::string, int>;  // address and camera id
  struct Place {                            // a camera's position
    Eigen::Vector3d mm;
    double heard_s;  // the camera's last detection or geometry
    bool is_named;
  };
  struct Holder {  // the camera that currently owns an id
    Heard newest;
    double heard_s = 0;
    OtherClock clock;
  };

  void forget(double now_s);
  void note_places(const VisionMessage& message, const std::string& address, bool is_named, double now_s);

  std::set<int> own_;
  std::map<Key, Place> places_;
  std::map<int, Holder> holders_;                         // by camera id
  std::map<Key, std::pair<double, Conflict>> conflicts_;  // limited like places_, which contains all keys
  struct Wait {
    double since_s, heard_s;
    bool geometry_came = false;
  };
  std::map<Key, Wait> without_place_;  // of named computers, so limited
};

}  // namespace sslv
