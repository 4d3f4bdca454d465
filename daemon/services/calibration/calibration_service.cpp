// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_service.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "services/calibration/calibration_report.h"
#include "services/calibration/calibration_request.h"
#include "services/cameras/camera_routes.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Returns the part of the lines to which the field's sizes were measured: as found by the job, else as
/// requested, else to the middle, as in the rules.
LinesMeasured lines_measured_to(const CalibrationJobs::Job& job) {
  if (job.report) return job.report->measured;
  if (job.order) return job.order->request.lines_measured_to.value_or(LinesMeasured::kToMiddle);
  return LinesMeasured::kToMiddle;
}

}  // namespace

CalibrationService::CalibrationService(const Snapshot<Config>& config, SettingsEditor& settings,
                                       Cameras& cameras, CalibrationRecords& records, MatchLock& match_lock,
                                       const RefereeListener& referee)
    : config_(config),
      settings_(settings),
      cameras_(cameras),
      records_(records),
      match_lock_(match_lock),
      referee_(referee),
      jobs_(make_calibration_jobs(frames_of(cameras))) {
  cameras.add_observer(*this);
}

void CalibrationService::cameras_changed(const std::set<int>& camera_ids) noexcept {
  invalidate(jobs_, camera_ids);
}

std::vector<Route> CalibrationService::routes() {
  const auto call = [this](Response (CalibrationService::*handle)(const Request&)) -> Handler {
    return [this, handle](const Request& request) {
      cameras_.get(path_camera_id(request));
      return (this->*handle)(request);
    };
  };
  return {
      {"GET", R"(/api/cameras/(\d+)/calibration)",
       [this](const Request& request) {
         return json_response(state_json(cameras_.get(path_camera_id(request)).id));
       }},
      // These handlers check the match lock themselves where needed.
      {"POST", R"(/api/cameras/(\d+)/calibration)", call(&CalibrationService::start), Needs::kChange},
      {"DELETE", R"(/api/cameras/(\d+)/calibration)", call(&CalibrationService::cancel), Needs::kChange},
      {"POST", R"(/api/cameras/(\d+)/calibration/accept)", call(&CalibrationService::accept), Needs::kChange},
      {"POST", R"(/api/cameras/(\d+)/calibration/reject)", call(&CalibrationService::reject), Needs::kChange},
      {"POST", R"(/api/cameras/(\d+)/calibration/revert)", call(&CalibrationService::revert), Needs::kChange},
  };
}

Json CalibrationService::state_json(int camera_id) const {
  const auto config = config_.load();
  const CalibrationJobs::Job job = jobs_.job(camera_id);
  Json out = job_json(job);
  out.update({{"camera", camera_id},
              {"calibration", nullptr},
              {"game_is_running", referee_.game_is_running()},
              {"lines_measured_to", name_of(lines_measured_to(job))},
              {"points", named_points_json(config->field, lines_measured_to(job))},
              {"history", records_.history_json(camera_id)}});
  for (const CameraSettings& camera : config->cameras) {
    if (camera.id == camera_id && camera.calibration)
      out["calibration"] = params_to_json(*camera.calibration);
  }
  return out;
}

Response CalibrationService::start(const Request& request) {
  const int camera_id = path_camera_id(request);
  Json body = body_json(request);
  const bool force = take_force(body);
  CalibrationOrder order{read_calibration_request(body), {}, {}, request.address, unix_time_s()};
  if (!force) match_lock_.refuse_if_locked(kOrForce);
  const auto config = config_.load();
  order.field = config->field;
  for (const CameraSettings& camera : config->cameras) {
    if (camera.id == camera_id) order.previous = camera.calibration;
  }
  if (!jobs_.start(camera_id, std::move(order)))
    throw HttpError(409, fmt::format("camera {} is being calibrated already; cancel that first", camera_id));
  log::info("camera {}: calibration started by {}", camera_id, request.address);
  return json_response(state_json(camera_id), 202);
}

Response CalibrationService::cancel(const Request& request) {
  const int camera_id = path_camera_id(request);
  if (!jobs_.cancel(camera_id))
    throw HttpError(409, fmt::format("camera {} is not being calibrated", camera_id));
  return json_response(state_json(camera_id));
}

Response CalibrationService::reject(const Request& request) {
  const int camera_id = path_camera_id(request);
  const CalibrationJobs::Job job = jobs_.job(camera_id);
  if (!job.order || !jobs_.forget(camera_id, job.report.get()))
    throw HttpError(409, fmt::format("camera {} has no finished calibration to reject", camera_id));
  return json_response(state_json(camera_id));
}

Response CalibrationService::accept(const Request& request) {
  const int camera_id = path_camera_id(request);
  const bool force = force_of(request);
  // Read before the job: if the camera changes from now on, these settings are outdated and accept() fails.
  const SettingsStore::Version current = settings_.current();
  const CalibrationJobs::Job job = jobs_.job(camera_id);
  if (!job.report || !job.report->found)
    throw HttpError(409, fmt::format("camera {} has no new calibration to accept", camera_id));
  if (!force)
    refuse_acceptance(match_lock_, job.report->accepted, job.report->problems,
                      fmt::format("camera {}'s new calibration is", camera_id));
  records_.accept({{camera_id, job.report->calibration, figures_json(*job.report)}}, current,
                  request.address);
  jobs_.forget(camera_id, job.report.get());
  return json_response(state_json(camera_id));
}

Response CalibrationService::revert(const Request& request) {
  const int camera_id = path_camera_id(request);
  const bool force = force_of(request);
  if (!force) match_lock_.refuse_if_locked(kOrForce);
  records_.revert(camera_id, force, request.address);
  return json_response(state_json(camera_id));
}

void CalibrationService::report(HealthReport& report) const {
  const auto stale = stale_.load();
  std::vector<CalibrationFacts> cameras;
  for (const CameraNow& camera : cameras_.all()) {
    const auto& model = camera.context().scene->camera;
    cameras.push_back({camera.id, camera.health.width, camera.health.height,
                       model ? std::optional(model->calibration()) : std::nullopt,
                       stale->contains(camera.id)});
  }
  report_calibrations(cameras, report);
}

std::vector<SupportFile> CalibrationService::support_files() const {
  std::vector<SupportFile> files;
  for (const CameraNow& camera : cameras_.all()) {
    files.push_back({fmt::format("camera_{}/calibration.json", camera.id),
                     "its calibrations: reports, figures, history",
                     [this, id = camera.id] { return json_text(state_json(id), 2) + "\n"; }});
  }
  return files;
}

void CalibrationService::each_second() {
  const auto config = config_.load();
  if (config == looked_at_) return;
  looked_at_ = config;
  stale_.store(records_.find_stale());
}

}  // namespace sslv
