// SPDX-License-Identifier: Apache-2.0
#include "tracking/gather.h"

#include "geometry/limits.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/LU>

namespace sslv {
namespace {

using Eigen::Matrix2d, Eigen::Vector2d;

constexpr double kMaxAngleSigma_rad = 100;

/// Whether the covariance is positive and smaller than any field.
bool is_sensible(const Matrix2d& cov_mm2) {
  constexpr double kMaxMm2 = 1e10;
  return cov_mm2.allFinite() && cov_mm2(0, 0) > 0 && cov_mm2(1, 1) > 0 && cov_mm2.determinant() > 0 &&
         cov_mm2.trace() < kMaxMm2;
}

}  // namespace

bool Gather::is_taken(const Params& params, const ArrivedSightings& arrived, double now_s,
                      LeftOut& left_out) {
  const CameraSightings& image = arrived.image;
  const auto leave_out = [&](LeftOut::Why why, std::uint64_t& count) {
    ++count;
    left_out.why = why;
    left_out.camera = image.camera;
    left_out.t_s = now_s;
    return false;
  };
  if (!(std::abs(image.t_capture_s - now_s) <= params.max_time_off_s))
    return leave_out(LeftOut::Why::kTime, left_out.images_off_time);
  constexpr double kForgotten_s = 10;
  std::erase_if(heard_, [&](const auto& one) { return std::abs(now_s - one.second.t_s) > kForgotten_s; });
  // Other computers' cameras never replace our own.
  if (image.is_of_other_computer && !heard_.contains(image.camera) && heard_.size() >= limits::kMaxCameras)
    return leave_out(LeftOut::Why::kTooMany, left_out.images_of_too_many);
  heard_[image.camera] = {now_s, image.is_of_other_computer};
  if (heard_.size() <= limits::kMaxCameras) return true;
  // Our own camera replaces the other computers' camera that has been silent for longest.
  const auto silent = std::ranges::min_element(heard_, {}, [](const auto& one) {
    return std::pair(!one.second.is_of_other_computer, one.second.t_s);
  });
  if (silent->second.is_of_other_computer) heard_.erase(silent);
  return true;
}

void Gather::process(const Params& params, const FieldSize& field, const FieldClock& clock,
                     const ArrivedSightings& arrived, CameraSightings& out, LeftOut& left_out) noexcept {
  const CameraSightings& image = arrived.image;
  const double now_s = clock.now_s();
  out.camera = image.camera;
  out.frame_number = image.frame_number;
  out.t_capture_s = image.t_capture_s;
  out.camera_mm = image.camera_mm;
  out.is_of_other_computer = image.is_of_other_computer;
  out.robots.clear();
  out.balls.clear();
  left_out.sightings += arrived.left_out;
  out.is_taken = image.is_taken && is_taken(params, arrived, now_s, left_out);
  if (!out.is_taken) return;
  const auto is_near = [&](const Vector2d& place_mm) {
    return std::abs(place_mm.x()) <= field.field_length / 2.0 + params.reach_mm &&
           std::abs(place_mm.y()) <= field.field_width / 2.0 + params.reach_mm;
  };
  for (const RobotSighting& seen : image.robots) {
    const bool is_known = std::any_of(out.robots.begin(), out.robots.end(), [&](const auto& one) {
      return one.team == seen.team && one.id == seen.id;
    });
    if (is_known || !is_near(seen.place_mm)) {
      ++left_out.sightings;
      continue;
    }
    RobotSighting robot = seen;
    if (image.is_of_other_computer || !is_sensible(robot.place_cov_mm2) ||
        !(robot.orientation_sigma_rad > 0 && robot.orientation_sigma_rad < kMaxAngleSigma_rad)) {
      robot.place_cov_mm2 = params.robot_sigma_mm * params.robot_sigma_mm * Matrix2d::Identity();
      robot.orientation_sigma_rad = params.orientation_sigma_deg * std::numbers::pi / 180;
    }
    out.robots.push_back(robot);
  }
  for (const BallSighting& seen : image.balls) {
    if (!is_near(seen.place_mm)) {
      ++left_out.sightings;
      continue;
    }
    BallSighting ball = seen;
    if (image.is_of_other_computer || !is_sensible(ball.place_cov_mm2))
      ball.place_cov_mm2 = params.ball_sigma_mm * params.ball_sigma_mm * Matrix2d::Identity();
    out.balls.push_back(ball);
  }
}

}  // namespace sslv
