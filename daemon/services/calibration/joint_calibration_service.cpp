// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/joint_calibration_service.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "calibration/joint_calibration_json.h"
#include "services/calibration/calibration_request.h"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string joined(const std::vector<int>& ids) {
  std::string out;
  for (const int id : ids) out += (out.empty() ? "" : ", ") + std::to_string(id);
  return out;
}

/// The requested cameras, with their current calibrations. Throws SettingsError for an unknown id or if there
/// is only one id, HttpError 409 for cameras that are not calibrated.
std::vector<JointCalibrationOrder::Camera> cameras_for(const JointCalibrationRequest& request,
                                                       const Config& config) {
  std::vector<int> known;
  std::vector<JointCalibrationOrder::Camera> out;
  for (const CameraSettings& camera : config.cameras) known.push_back(camera.id);
  for (std::size_t i = 0; i < request.cameras.size(); ++i) {
    if (std::find(known.begin(), known.end(), request.cameras[i]) != known.end()) continue;
    throw SettingsError(
        fmt::format("/cameras/{}: no camera {}; known: {}", i, request.cameras[i], joined(known)));
  }
  if (request.cameras.size() == 1) {
    throw SettingsError("/cameras: 1 is too few; expected two or more, or none for all that are calibrated");
  }
  for (const CameraSettings& camera : config.cameras) {
    const bool is_named =
        std::find(request.cameras.begin(), request.cameras.end(), camera.id) != request.cameras.end();
    if (camera.calibration && (is_named || request.cameras.empty())) {
      out.push_back({camera.id, *camera.calibration});
    } else if (is_named) {
      throw HttpError(409, fmt::format("camera {} is not calibrated: calibrate it first", camera.id));
    }
  }
  if (out.size() < 2) {
    throw HttpError(409, fmt::format("{} of {} cameras {} calibrated: calibrate two or more first",
                                     out.size(), config.cameras.size(), out.size() == 1 ? "is" : "are"));
  }
  return out;
}

}  // namespace

JointCalibrationService::JointCalibrationService(const Snapshot<Config>& config, SettingsEditor& settings,
                                                 Cameras& cameras, CalibrationRecords& records,
                                                 MatchLock& match_lock, const RefereeListener& referee)
    : config_(config),
      settings_(settings),
      records_(records),
      match_lock_(match_lock),
      referee_(referee),
      jobs_(make_joint_calibration_jobs(frames_of(cameras))) {
  cameras.add_observer(*this);
}

void JointCalibrationService::cameras_changed(const std::set<int>& camera_ids) noexcept {
  invalidate(jobs_, camera_ids);
}

std::vector<Route> JointCalibrationService::routes() {
  return {
      {"GET", "/api/calibration", [this](const Request&) { return state(); }},
      {"POST", "/api/calibration", [this](const Request& request) { return start(request); }, Needs::kChange},
      {"DELETE", "/api/calibration", [this](const Request&) { return cancel(); }, Needs::kChange},
      {"POST", "/api/calibration/accept", [this](const Request& request) { return accept(request); },
       Needs::kChange},
      {"POST", "/api/calibration/reject", [this](const Request&) { return reject(); }, Needs::kChange},
  };
}

Response JointCalibrationService::state() const {
  const JointCalibrationJobs::Job job = jobs_.job(kJointKey);
  Json out = job_json(job);
  out.update({{"ties", job.ties}, {"game_is_running", referee_.game_is_running()}});
  return json_response(out);
}

Response JointCalibrationService::start(const Request& request) {
  Json body = body_json(request);
  const bool force = take_force(body);
  auto wanted = params_from_json<JointCalibrationRequest>(body, "");
  if (!force) match_lock_.refuse_if_locked(kOrForce);
  const auto config = config_.load();
  auto cameras = cameras_for(wanted, *config);
  wanted.cameras.clear();
  for (const JointCalibrationOrder::Camera& camera : cameras) wanted.cameras.push_back(camera.id);
  const std::string ids = joined(wanted.cameras);
  if (!jobs_.start(kJointKey,
                   {std::move(wanted), std::move(cameras), config->field, request.address, unix_time_s()})) {
    throw HttpError(409, "cameras are being calibrated together already; cancel that first");
  }
  log::info("cameras {}: calibration together started by {}", ids, request.address);
  Response response = state();
  response.status = 202;
  return response;
}

Response JointCalibrationService::cancel() {
  if (!jobs_.cancel(kJointKey)) throw HttpError(409, "no cameras are being calibrated together");
  return state();
}

Response JointCalibrationService::reject() {
  const JointCalibrationJobs::Job job = jobs_.job(kJointKey);
  if (!job.order || !jobs_.forget(kJointKey, job.report.get()))
    throw HttpError(409, "there is no finished joint calibration to reject");
  return state();
}

Response JointCalibrationService::accept(const Request& request) {
  const bool force = force_of(request);
  // Read before the job: if a camera changes from now on, these settings are outdated and accept() fails.
  const SettingsStore::Version current = settings_.current();
  const JointCalibrationJobs::Job job = jobs_.job(kJointKey);
  if (!job.report || !job.report->found) throw HttpError(409, "there is no new joint calibration to accept");
  if (!force)
    refuse_acceptance(match_lock_, job.report->accepted, job.report->problems, "the new calibrations are");
  std::vector<NewCalibration> calibrations;
  for (const JointCameraReport& camera : job.report->cameras)
    calibrations.push_back({camera.id, camera.calibration, joint_figures_json(*job.report, camera)});
  records_.accept(calibrations, current, request.address);
  jobs_.forget(kJointKey, job.report.get());
  return state();
}

}  // namespace sslv
