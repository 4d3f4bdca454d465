// SPDX-License-Identifier: Apache-2.0
#include "tracking/agreement.h"

#include <algorithm>
#include <cmath>

namespace sslv {

using Eigen::Vector2d;

void Agreement::process(const Params&, const CameraSightings& seen, const ImageTime& time, Observations& out,
                        CameraAgreement& learnt) noexcept {
  out.robots.clear();
  out.balls.clear();
  if (!time.t_s) return;
  const double t_s = *time.t_s;
  learnt.set_camera(seen.camera, seen.camera_mm, seen.is_of_other_computer);
  learnt.set_evenness(seen.camera, time.evenness);
  constexpr double kSetBack_s = 1;
  if (newest_s_ && t_s < *newest_s_ - kSetBack_s) newest_s_.reset();
  if (newest_s_ && t_s > *newest_s_) learnt.follow(t_s - *newest_s_);
  newest_s_ = std::max(t_s, newest_s_.value_or(t_s));

  const double true_s = t_s - learnt.time_offset_s(seen.camera);
  for (const RobotSighting& robot : seen.robots) {
    const RobotName name{robot.team, robot.id};
    const Vector2d place = robot.place_mm - learnt.error_of(seen.camera, robot.place_mm) -
                           learnt.height_error_of(seen.camera, name, robot.place_mm, robot.height_mm);
    out.robots.push_back({name, seen.camera, true_s, time.sigma_s, place, robot.orientation_rad,
                          robot.place_cov_mm2, robot.orientation_sigma_rad, robot.height_mm,
                          seen.is_of_other_computer});
    learnt.see(seen.camera, {name, robot.place_mm, robot.height_mm, t_s});
  }
  /// Calibration errors, which vary from place to place.
  constexpr double kPlaceSigmaMm = 0.3;
  for (const BallSighting& ball : seen.balls) {
    const double sigma_mm = std::sqrt(ball.place_cov_mm2.trace() / 2);
    out.balls.push_back({true_s, seen.camera_mm, ball.place_mm, std::hypot(sigma_mm, kPlaceSigmaMm),
                         ball.height_mm, ball.height_sigma_mm});
  }
}

}  // namespace sslv
