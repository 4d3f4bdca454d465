// SPDX-License-Identifier: Apache-2.0
#include "services/verdict/verdict_service.h"

#include "services/verdict/verdict_report.h"

#include <utility>

namespace sslv {

VerdictService::VerdictService(const Snapshot<Config>& config, Cameras& cameras)
    : config_(config), cameras_(cameras), watch_(cameras) {
  cameras.add_observer(*this);
}

void VerdictService::cameras_changed(const std::set<int>& camera_ids) noexcept {
  watch_.forget(camera_ids);
}

void VerdictService::report(HealthReport& report) const {
  const auto config = config_.load();
  const auto coverage = coverage_.load();
  report_verdict({*config, watch_.seen(), *coverage}, report);
  if (!report.status) return;
  Json uncovered = Json::array();
  for (const Eigen::Vector2d& place : coverage->uncovered_mm) uncovered.push_back({place.x(), place.y()});
  (*report.status)["coverage"] = {{"grid_mm", Coverage::kGridMm}, {"uncovered", std::move(uncovered)}};
}

void VerdictService::each_second() {
  const std::vector<CameraNow> cameras = cameras_.all();
  std::vector<std::shared_ptr<const void>> covered_by;
  for (const CameraNow& camera : cameras) {
    const CameraContext& context = camera.context();
    covered_by.insert(covered_by.end(), {context.scene, context.mask, context.stage_mask});
  }
  if (covered_by == covered_by_ && !covered_by.empty()) return;
  covered_by_ = std::move(covered_by);
  coverage_.store(coverage_of(cameras, config_.load()->field));
}

}  // namespace sslv
