// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/verdict_service.h"

#include "base/clock.h"
#include "config/backends.h"
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
  expect_nothing_of_replaced_cameras();
}

void VerdictService::expect_nothing_of_replaced_cameras() {
  std::map<int, std::string> now;
  for (const CameraNow& camera : cameras_.all()) now[camera.id] = device_of(camera.settings->source);
  const std::lock_guard lock(devices_mutex_);
  std::set<int> replaced;
  for (const auto& [id, device] : std::exchange(devices_, now)) {
    const auto still = now.find(id);
    if (still == now.end() || still->second != device) replaced.insert(id);
  }
  watch_.expect_nothing_of(replaced);
}

void VerdictService::report(HealthReport& report) const {
  const auto config = config_.load();
  const auto coverage = coverage_.load();
  const RefereeStatus referee = referee_.status(steady_s());
  const bool is_heard = referee.silent_s.value_or(1e9) <= RefereeListener::kForgottenAfter_s;
  const auto match_since = *match_since_.load();
  report_verdict({.config = *config,
                  .seen = watch_.seen(match_since ? std::optional(match_since->steady_s) : std::nullopt,
                                      {config->field, is_heard ? referee.blue_at_positive_x : std::nullopt}),
                  .coverage = *coverage,
                  .robots_allowed = is_heard ? referee.robots_allowed : decltype(referee.robots_allowed){},
                  .match_runs = match_since.has_value(),
                  .half_is_next = is_heard && referee.half_is_next(),
                  .robots_are_handled = referee.robots_are_handled},
                 report);
  if (!report.status) return;
  Json uncovered = Json::array();
  for (const Eigen::Vector2d& place : coverage->uncovered_mm) uncovered.push_back({place.x(), place.y()});
  (*report.status)["match_since"] = match_since ? Json(match_since->unix_s) : Json(nullptr);
  (*report.status)["coverage"] = {{"grid_mm", Coverage::kGridMm}, {"uncovered", std::move(uncovered)}};
}

void VerdictService::each_second() {
  const RefereeStatus referee = referee_.status(steady_s());
  watch_.robots_are_handled(referee.match_runs() && referee.robots_are_handled);
  if (referee.match_runs() != match_since_.load()->has_value()) {
    match_since_.store(referee.match_runs() ? std::optional(MatchSince{unix_time_s(), steady_s()})
                                            : std::nullopt);
  }

  expect_nothing_of_replaced_cameras();
  const std::vector<CameraNow> cameras = cameras_.all();
  std::vector<CoveredBy> covered_by;
  for (const CameraNow& camera : cameras) {
    const CameraContext& context = camera.context();
    covered_by.push_back({camera.id, context.scene, context.mask, context.stage_mask,
                          camera.health.state == CameraState::kRunning, camera.health.width,
                          camera.health.height});
  }
  if (covered_by == covered_by_ && !covered_by.empty()) return;
  covered_by_ = std::move(covered_by);
  coverage_.store(coverage_of(cameras, config_.load()->field));
}

}  // namespace sslv
