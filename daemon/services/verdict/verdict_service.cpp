// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/verdict_service.h"

#include "base/clock.h"
#include "services/verdict/verdict_report.h"

#include <utility>

namespace sslv {

VerdictService::VerdictService(const Snapshot<Config>& config, Cameras& cameras,
                               const RefereeListener& referee)
    : config_(config), cameras_(cameras), referee_(referee), watch_(cameras) {
  cameras.add_observer(*this);
}

void VerdictService::cameras_changed(const std::set<int>& camera_ids) noexcept {
  watch_.forget(camera_ids);
}

void VerdictService::report(HealthReport& report) const {
  const auto config = config_.load();
  const auto coverage = coverage_.load();
  const RefereeStatus referee = referee_.status(steady_s());
  const bool is_heard = referee.silent_s.value_or(1e9) <= RefereeListener::kForgottenAfter_s;
  const double match_since_s = match_since_s_;
  report_verdict({.config = *config,
                  .seen = watch_.seen(),
                  .coverage = *coverage,
                  .robots_allowed = is_heard ? referee.robots_allowed : decltype(referee.robots_allowed){},
                  .match_runs = match_since_s > 0},
                 report);
  if (!report.status) return;
  Json uncovered = Json::array();
  for (const Eigen::Vector2d& place : coverage->uncovered_mm) uncovered.push_back({place.x(), place.y()});
  (*report.status)["match_since"] = match_since_s > 0 ? Json(match_since_s) : Json(nullptr);
  (*report.status)["coverage"] = {{"grid_mm", Coverage::kGridMm}, {"uncovered", std::move(uncovered)}};
}

void VerdictService::each_second() {
  const RefereeStatus referee = referee_.status(steady_s());
  // A game controller that falls silent does not end a match; one that was switched off long ago does.
  constexpr double kMaxSilence_s = 600;
  const bool match_runs = referee.stage_is_played && referee.silent_s.value_or(1e9) < kMaxSilence_s;
  if (match_runs != (match_since_s_ > 0)) match_since_s_ = match_runs ? unix_time_s() : 0;

  const std::vector<CameraNow> cameras = cameras_.all();
  std::vector<std::shared_ptr<const void>> covered_by;
  for (const CameraNow& camera : cameras) {
    const CameraContext& context = camera.context();
    covered_by.insert(covered_by.end(), {context.scene, context.mask, context.stage_mask});
    if (camera.health.state != CameraState::kRunning) covered_by.emplace_back();
  }
  if (covered_by == covered_by_ && !covered_by.empty()) return;
  covered_by_ = std::move(covered_by);
  coverage_.store(coverage_of(cameras, config_.load()->field));
}

}  // namespace sslv
