// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "geometry/limits.h"
#include "geometry/scene.h"
#include "tracking/frame_clock.h"
#include "tracking/sightings.h"
#include "tracking/tracks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <tuple>
#include <vector>

#include <Eigen/Core>

namespace sslv {

/// Learns from moving robots how far a camera's time stamps should be moved towards a constant rate. Cameras
/// with a trigger take images evenly, and their stamps jitter; webcams, automatic exposure and simulators
/// take images unevenly, and their stamps are right.
///
/// Of three successive images, the middle one shows each robot between its two other places. How far along is
/// the share of time that has passed: the wrong times put all fast robots ahead or behind.
class Evenness {
 public:
  /// Adds an image: its time stamp, the time `even_s` of a camera with a constant rate, and the rms
  /// difference between the two.
  void add(const CameraSightings& seen, double even_s, double jitter_s);
  /// 0: the stamps are right. 1: the constant rate is right.
  double share() const { return share_; }

 private:
  struct Robot {
    RobotName name;
    Eigen::Vector2d place_mm;
    double var_mm2;
  };
  struct Image {
    double stamp_s = 0, moved_s = 0;  // moved_s: even_s - stamp_s
    std::vector<Robot> robots;
  };
  void compare(const Image& before, const Image& middle, const Image& after);

  std::array<Image, 3> images_;  // a ring
  std::size_t count_ = 0;
  double share_ = 1;
  // Normal equation of the share: information_ * share = weighted_.
  double information_ = 0, weighted_ = 0;
};

/// Estimates the true capture time of an image: its time stamp, moved towards the constant rate of the camera
/// (FrameClock) as far as the robots' motion confirms it (Evenness).
class Clocks {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const CameraSightings& seen, ImageTime& out) noexcept {
    out = {};
    if (!seen.is_taken) return;
    // Other computers may send any number of ids.
    if (cameras_.size() >= limits::kMaxCameras && !cameras_.contains(seen.camera))
      cameras_.erase(
          std::ranges::min_element(cameras_, {}, [](const auto& one) { return one.second.seen_s; }));
    Camera& camera = cameras_[seen.camera];
    camera.seen_s = seen.t_capture_s;
    const double even_s = camera.clock.time_of(seen.t_capture_s), jitter_s = camera.clock.jitter_s();
    camera.evenness.add(seen, even_s, jitter_s);
    const double share = camera.evenness.share();
    out.t_s = seen.t_capture_s + share * (even_s - seen.t_capture_s);
    out.evenness = share;
    out.sigma_s = std::hypot((1 - share) * FrameClock::kLeastSigma_s, share * camera.clock.sigma_s(),
                             std::min(share, 1 - share) * jitter_s);
  }

 private:
  struct Camera {
    double seen_s = 0;
    FrameClock clock;
    Evenness evenness;
  };
  std::map<int, Camera> cameras_;  // by camera
};

}  // namespace sslv
