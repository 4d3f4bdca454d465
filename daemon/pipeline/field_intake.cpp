// SPDX-License-Identifier: Apache-2.0
#include "pipeline/field_intake.h"

#include "base/clock.h"
#include "pipeline/validate.h"

#include <algorithm>
#include <cmath>

namespace sslv {
namespace {

/// Minimum relative uncertainty of a ball's radius, from which the ball's height is estimated: edges in
/// images are less sharp than the fit assumes.
constexpr double kRadiusSigmaShare = 0.02;

Eigen::Matrix2d matrix_of(const PlaceCov& cov) {
  Eigen::Matrix2d out;
  out << cov.xx_mm2, cov.xy_mm2, cov.xy_mm2, cov.yy_mm2;
  return out;
}

BallSighting sighting_of(const Ball& ball, double ball_radius_mm, double camera_height_mm) {
  BallSighting out{{ball.x_mm, ball.y_mm}, matrix_of(ball.place_cov), ball.confidence};
  if (!(ball.radius_sigma_mm > 0) || !(ball.radius_mm > 0) || std::isinf(ball.radius_mm)) return out;
  const double up_mm = camera_height_mm - ball_radius_mm;
  const double height_mm = ball_radius_mm + up_mm * (1 - ball_radius_mm / ball.radius_mm);
  if (!(std::abs(height_mm) < limits::kMaxPlaceMm)) return out;
  out.height_mm = height_mm;
  out.height_sigma_mm =
      up_mm * std::hypot(ball.radius_sigma_mm, kRadiusSigmaShare * ball_radius_mm) / ball_radius_mm;
  return out;
}

/// Writes an image's detections to `out`. The lists of `out` keep their memory.
void write_sightings(const FrameInfo& info, const Scene& scene, const RobotList& robots,
                     const BallList& balls, CameraSightings& out) noexcept {
  out.camera = static_cast<int>(info.camera_id);
  out.frame_number = info.number;
  out.t_capture_s = info.times.t_capture_s;
  out.camera_mm = scene.camera ? scene.camera->position_mm() : Eigen::Vector3d(0, 0, 0);
  out.robots.clear();
  for (const Robot& robot : robots.robots) {
    if (out.robots.size() == limits::kMaxRobots) break;
    out.robots.push_back({robot.team,
                          robot.id,
                          {robot.x_mm, robot.y_mm},
                          robot.orientation_rad,
                          robot.height_mm,
                          matrix_of(robot.place_cov),
                          robot.orientation_sigma_rad});
  }
  out.balls.clear();
  for (const Ball& ball : balls.balls) {
    if (out.balls.size() == limits::kMaxFieldBalls) break;
    out.balls.push_back(sighting_of(ball, scene.field.ball_radius, out.camera_mm.z()));
  }
  out.is_taken = true;
  out.is_of_other_computer = false;
}

}  // namespace

SightingsQueue::SightingsQueue(std::shared_ptr<Bell> bell) : bell_(std::move(bell)) {
  queue_.prepare([](ArrivedSightings& slot) {
    slot.image.robots.reserve(limits::kMaxRobots);
    slot.image.balls.reserve(limits::kMaxFieldBalls);
  });
}

ArrivedSightings* SightingsQueue::begin() noexcept {
  ArrivedSightings* const slot = queue_.to_write();
  if (!slot) lost_.fetch_add(1, std::memory_order_relaxed);
  return slot;
}

void SightingsQueue::end(ArrivedSightings& slot) noexcept {
  slot.handed_over_ns = steady_ns();
  queue_.write();
  bell_->ring();
}

void SightingsQueue::hand_over(const FrameInfo& info, const Scene& scene, const RobotList& robots,
                               const BallList& balls) noexcept {
  if (!scene.camera) return;
  ArrivedSightings* const slot = begin();
  if (!slot) return;
  write_sightings(info, scene, robots, balls, slot->image);
  const InvalidCounts dropped = drop_invalid(slot->image);
  slot->left_out = dropped.robots + dropped.balls;
  end(*slot);
}

void SightingsQueue::hand_over(const ArrivedSightings& heard) noexcept {
  ArrivedSightings* const slot = begin();
  if (!slot) return;
  *slot = heard;  // the lists keep their memory
  end(*slot);
}

std::shared_ptr<SightingsQueue> FieldIntake::add() {
  auto queue = std::make_shared<SightingsQueue>(bell_);
  const std::lock_guard lock(mutex_);
  Queues queues = *queues_.load();
  queues.push_back(queue);
  queues_.store(std::move(queues));
  return queue;
}

void FieldIntake::drop_unused() {
  const std::lock_guard lock(mutex_);
  Queues queues = *queues_.load();
  // The current list holds one reference, this copy holds another one.
  constexpr long kOurs = 2;
  const auto is_unused = [&](const auto& queue) { return queue.use_count() <= kOurs; };
  if (std::none_of(queues.begin(), queues.end(), is_unused)) return;
  for (const auto& queue : queues) {
    if (is_unused(queue)) lost_before_ += queue->lost();
  }
  std::erase_if(queues, is_unused);
  queues_.store(std::move(queues));
}

std::uint64_t FieldIntake::lost() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t lost = lost_before_;
  for (const auto& queue : *queues_.load()) lost += queue->lost();
  return lost;
}

}  // namespace sslv
