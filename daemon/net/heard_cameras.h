// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/sightings.h"

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

class SSL_WrapperPacket;

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

/// Makes sightings of what other visions send of their cameras. Not for several threads at once.
class HeardCameras {
 public:
  /// Whose packets are left out, and why.
  struct Conflict {
    int camera = 0;
    std::string address;     // of the vision that is not listened to
    std::string instead_of;  // whose camera of that id is; empty: it is our own
    bool operator==(const Conflict&) const = default;
  };

  /// Ids of this computer's own cameras: others with such an id are left out.
  void set_own(std::set<int> camera_ids) { own_ = std::move(camera_ids); }

  /// Takes a packet at a monotonic time, and by this computer's clock. True when `out` is what a camera saw.
  bool read(const SSL_WrapperPacket& packet, const std::string& address, double now_s, double unix_s,
            CameraSightings& out);

  /// Of the last seconds.
  std::vector<Conflict> conflicts(double now_s) const;
  struct Heard {
    std::string address;
    double clock_correction_s;
  };
  /// Other computers' cameras that are heard now, by their ids.
  std::map<int, Heard> cameras(double now_s) const;

  /// So long after its last packet, another vision may have the camera's id.
  static constexpr double kForgottenAfter_s = 2;

 private:
  using Key = std::pair<std::string, int>;  // address and camera id
  struct Holder {
    std::string address;
    double heard_s;
    OtherClock clock;
  };

  std::set<int> own_;
  std::map<Key, Eigen::Vector3d> places_mm_;  // where cameras hang
  std::map<int, Holder> holders_;             // by camera id
  std::map<Key, std::pair<double, Conflict>> conflicts_;
};

}  // namespace sslv
