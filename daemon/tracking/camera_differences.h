// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include <Eigen/Core>

namespace sslv {

/// Estimates the remaining offsets between the cameras that see one object, so that the object's track does
/// not jump when the camera changes. The differences between cameras that see the object at the same time are
/// kept; the common offset of these cameras decays. `Camera`: key of a camera. Holds the kCount cameras that
/// saw the object last.
template <class Camera, std::size_t kCount>
class CameraDifferences {
 public:
  /// Offsets of `most_mm` and more are not due to a camera. `starts_alone`: if a camera sees the object again
  /// after a gap, and no other camera sees it, the camera's innovation becomes its offset, so that the track
  /// stays at its prediction.
  CameraDifferences(double most_mm, bool starts_alone) : most_mm_(most_mm), starts_alone_(starts_alone) {}

  /// Restarts with this camera as the only one that has seen the object.
  void start(const Camera& camera, double t_s) {
    all_.fill({});
    of(camera).seen_s = t_s;
  }

  /// Updates the offsets with this camera's innovation `off_mm`. Returns the offset to subtract from `off_mm`
  /// (mm).
  Eigen::Vector2d take(const Camera& camera, double t_s, const Eigen::Vector2d& off_mm) {
    constexpr double kNew_s = 0.25, kAlso_s = 0.04, kFades_s = 0.5, kLearns = 0.12;
    One& here = of(camera);
    const double gap_s = t_s - here.seen_s;
    const bool is_alone = std::none_of(
        all_.begin(), all_.end(), [&](const One& one) { return &one != &here && t_s - one.seen_s < kNew_s; });
    const bool is_kept = off_mm.norm() < most_mm_ && (starts_alone_ || !is_alone);
    if (gap_s > kNew_s) here.off_mm = is_kept ? off_mm : Eigen::Vector2d(0, 0);
    here.seen_s = t_s;
    Eigen::Vector2d common(0, 0);
    int count = 0;
    for (const One& one : all_) {
      if (t_s - one.seen_s > kAlso_s) continue;
      common += one.off_mm;
      ++count;
    }
    common *= (1 - std::exp(-std::clamp(gap_s, 0.0, kAlso_s) / kFades_s)) / count;
    for (One& one : all_) {
      if (t_s - one.seen_s <= kAlso_s) one.off_mm -= common;
    }
    Eigen::Vector2d out = here.off_mm;
    if (count > 1 && (off_mm - out).norm() < most_mm_) here.off_mm += kLearns * (off_mm - out);
    return out;
  }

 private:
  struct One {
    std::optional<Camera> camera;  // none: unused
    Eigen::Vector2d off_mm{0, 0};
    double seen_s = -1e9;
  };

  /// The camera's entry; a new camera replaces the camera whose last measurement of the object is oldest.
  One& of(const Camera& camera) {
    One* oldest = &all_[0];
    for (One& one : all_) {
      if (one.camera && *one.camera == camera) return one;
      if (one.seen_s < oldest->seen_s) oldest = &one;
    }
    *oldest = {};
    oldest->camera = camera;
    return *oldest;
  }

  double most_mm_;
  bool starts_alone_;
  std::array<One, kCount> all_;
};

}  // namespace sslv
