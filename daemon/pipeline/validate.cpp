// SPDX-License-Identifier: Apache-2.0
#include "pipeline/validate.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include <Eigen/Core>

namespace sslv {
namespace {

using namespace limits;

// These functions return false for NaN.

bool is_near(double value) {
  return std::abs(value) <= kMaxPlaceMm;
}

template <int kRows>
bool is_near(const Eigen::Matrix<double, kRows, 1>& value) {
  for (int i = 0; i < kRows; ++i) {
    if (!is_near(value[i])) return false;
  }
  return true;
}

bool is_share(double value) {
  return value >= 0 && value <= 1;
}

bool is_name(Team team, int id) {
  return (team == Team::kYellow || team == Team::kBlue) && id >= 0 && id <= kMaxId;
}

/// An unknown height has an infinite sigma.
bool is_height(double height_mm, double sigma_mm) {
  return sigma_mm >= 0 && (std::isinf(sigma_mm) || is_near(height_mm));
}

bool is_sighting(const RobotSighting& robot, double camera_height_mm) {
  return is_name(robot.team, robot.id) && is_near(robot.place_mm) && is_near(robot.orientation_rad) &&
         robot.height_mm >= 0 &&
         robot.height_mm <= std::min(kMaxRobotHeightMm, camera_height_mm - kMinAboveRobotMm);
}

bool is_sighting(const BallSighting& ball) {
  return is_near(ball.place_mm) && std::isfinite(ball.confidence) &&
         is_height(ball.height_mm, ball.height_sigma_mm);
}

// The trackers do not check the uncertainty of observations again.

bool is_observation(const RobotObservation& robot) {
  return is_name(robot.name.team, robot.name.id) && std::isfinite(robot.t_s) &&
         std::isfinite(robot.t_sigma_s) && is_near(robot.place_mm) && is_near(robot.orientation_rad) &&
         robot.place_cov_mm2.allFinite() && std::isfinite(robot.orientation_sigma_rad) &&
         is_near(robot.height_mm);
}

bool is_observation(const BallObservation& ball) {
  return std::isfinite(ball.t_s) && is_near(ball.camera_mm) && is_near(ball.place_mm) &&
         std::isfinite(ball.sigma_mm) && is_height(ball.height_mm, ball.height_sigma_mm);
}

template <class T, class Good>
std::uint64_t keep(std::vector<T>& list, std::size_t most, const Good& is_good) {
  const std::size_t before = list.size();
  // Usually all entries are valid, and nothing is moved.
  const auto is_bad = [&](const T& one) { return !is_good(one); };
  const auto first = std::find_if(list.begin(), list.end(), is_bad);
  if (first != list.end()) list.erase(std::remove_if(first, list.end(), is_bad), list.end());
  if (list.size() > most) list.erase(list.begin() + static_cast<std::ptrdiff_t>(most), list.end());
  return before - list.size();
}

}  // namespace

bool is_valid(const CaptureTimes& times) noexcept {
  return std::isfinite(times.t_capture_s) && std::isfinite(times.t_capture_camera_s.value_or(0)) &&
         std::isfinite(times.t_capture_sigma_s.value_or(0));
}

bool is_valid(const FrameInfo& info, const FrameInfo& of_camera) noexcept {
  constexpr double kMaxCorrection_s = 5;
  const auto place = [](const FrameInfo& one) {
    return std::tuple(one.camera_id, one.number, one.times.arrived_ns, one.whole.width, one.whole.height,
                      one.whole.x, one.whole.y);
  };
  return is_valid(info.times) && place(info) == place(of_camera) &&
         std::abs(info.times.t_capture_s - of_camera.times.t_capture_s) <= kMaxCorrection_s &&
         info.times.t_capture_sigma_s.value_or(0) >= 0;
}

bool is_camera_place(const Eigen::Vector3d& place_mm) noexcept {
  return place_mm.z() >= kMinCameraMm && place_mm.norm() <= kMaxCameraMm;
}

bool is_valid(const Robot& robot) noexcept {
  return is_name(robot.team, robot.id) && is_near(robot.x_mm) && is_near(robot.y_mm) &&
         is_near(robot.orientation_rad) && is_near(robot.height_mm) && is_near(robot.pixel_x) &&
         is_near(robot.pixel_y) && is_share(robot.confidence);
}

bool is_valid(const Ball& ball) noexcept {
  return is_near(ball.x_mm) && is_near(ball.y_mm) && is_near(ball.pixel_x) && is_near(ball.pixel_y) &&
         is_share(ball.confidence);
}

bool is_valid(const RobotMiss& miss) noexcept {
  return miss.why <= RobotMiss::Why::kConfidence && is_near(miss.pixel_x) && is_near(miss.pixel_y) &&
         is_near(miss.radius_px) && is_near(miss.value) && is_near(miss.limit);
}

bool is_valid(const TrackedRobot& robot) noexcept {
  return is_name(robot.name.team, robot.name.id) && is_near(robot.place_mm) && is_near(robot.velocity_mm_s) &&
         is_near(robot.orientation_rad) && is_near(robot.turn_rad_s) && std::isfinite(robot.place_sigma_mm) &&
         is_share(robot.visibility);
}

bool is_valid(const TrackedBall& ball) noexcept {
  return is_near(ball.place_mm) && is_near(ball.velocity_mm_s) && is_share(ball.visibility);
}

bool is_valid(const TrackedKick& kick) noexcept {
  return std::isfinite(kick.t_s) && is_near(kick.place_mm) && is_near(kick.velocity_mm_s) &&
         is_near(kick.landing_mm) && std::isfinite(kick.stop_s) && is_near(kick.stop_mm) &&
         (!kick.robot || is_name(kick.robot->team, kick.robot->id));
}

InvalidCounts drop_invalid(RobotList& list) noexcept {
  const auto good = [](const Robot& robot) { return is_valid(robot); };
  keep(list.misses, kMaxMisses, [](const RobotMiss& miss) { return is_valid(miss); });
  return {.robots = keep(list.robots, kMaxRobots, good) + keep(list.second_robots, kMaxRobots, good)};
}

InvalidCounts drop_invalid(BallList& list) noexcept {
  return {.balls = keep(list.balls, kMaxBalls, [](const Ball& ball) { return is_valid(ball); })};
}

InvalidCounts drop_invalid(CameraSightings& image) noexcept {
  const auto robot = [&](const RobotSighting& one) { return is_sighting(one, image.camera_mm.z()); };
  const auto ball = [](const BallSighting& one) { return is_sighting(one); };
  InvalidCounts out{.robots = keep(image.robots, kMaxRobots, robot),
                    .balls = keep(image.balls, kMaxFieldBalls, ball)};
  if (image.is_taken && !(std::isfinite(image.t_capture_s) && is_camera_place(image.camera_mm) &&
                          image.camera >= 0 && image.camera <= kMaxId)) {
    out.robots += image.robots.size();
    out.balls += image.balls.size();
    image.is_taken = false;
    image.robots.clear();
    image.balls.clear();
    ++out.others;
  }
  return out;
}

InvalidCounts drop_invalid(Observations& observations) noexcept {
  const auto good = [](const auto& one) { return is_observation(one); };
  return {.robots = keep(observations.robots, kMaxRobots, good),
          .balls = keep(observations.balls, kMaxFieldBalls, good)};
}

InvalidCounts drop_invalid(ImageTime& time) noexcept {
  if (!time.t_s || (std::isfinite(*time.t_s) && std::isfinite(time.sigma_s))) return {};
  time = {};
  return {.others = 1};
}

InvalidCounts drop_invalid(TrackedField& tracked) noexcept {
  InvalidCounts out;
  if (!std::isfinite(tracked.t_s)) {
    out = {tracked.robots.size(), tracked.balls.size(), 1};
    tracked.t_s = 0;
    tracked.robots.clear();
    tracked.balls.clear();
    tracked.kick.reset();
    return out;
  }
  const auto good = [](const auto& one) { return is_valid(one); };
  out = {.robots = keep(tracked.robots, kMaxRobots, good),
         .balls = keep(tracked.balls, kMaxFieldBalls, good)};
  if (tracked.kick && !is_valid(*tracked.kick)) {
    tracked.kick.reset();
    ++out.others;
  }
  return out;
}

}  // namespace sslv
