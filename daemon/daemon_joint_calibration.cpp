// SPDX-License-Identifier: Apache-2.0
// How several cameras are calibrated together: docs/api.md.
#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "calibration_json.h"
#include "daemon.h"
#include "web/http.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string joined(const std::vector<int>& ids) {
  std::string out;
  for (const int id : ids) out += (out.empty() ? "" : ", ") + std::to_string(id);
  return out;
}

/// The cameras that are meant, with their calibrations in force.
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

Json Daemon::joint_calibration() const {
  const JointCalibrationJobs::Job job = joint_calibration_jobs_.job(kJointKey);
  Json out = job_json(job);
  out.update({{"ties", job.ties}, {"game_is_running", referee_.game_is_running()}});
  return out;
}

Json Daemon::start_joint_calibration(const Json& json, bool force, const std::string& who) {
  auto request = params_from_json<JointCalibrationRequest>(json, "");
  if (!force) refuse_while_game_runs();
  const auto config = config_.load();
  auto cameras = cameras_for(request, *config);
  request.cameras.clear();
  for (const JointCalibrationOrder::Camera& camera : cameras) request.cameras.push_back(camera.id);
  const std::string ids = joined(request.cameras);
  if (!joint_calibration_jobs_.start(
          kJointKey, {std::move(request), std::move(cameras), config->field, who, unix_time_s()})) {
    throw HttpError(409, "cameras are being calibrated together already; cancel that first");
  }
  log::info("cameras {}: calibration together started by {}", ids, who);
  return joint_calibration();
}

Json Daemon::cancel_joint_calibration() {
  if (!joint_calibration_jobs_.cancel(kJointKey))
    throw HttpError(409, "no cameras are being calibrated together");
  return joint_calibration();
}

Json Daemon::reject_joint_calibration() {
  const JointCalibrationJobs::Job job = joint_calibration_jobs_.job(kJointKey);
  if (!job.order || !joint_calibration_jobs_.forget(kJointKey, job.report.get())) {
    throw HttpError(409, "there is no finished calibration of cameras together to reject");
  }
  return joint_calibration();
}

Json Daemon::accept_joint_calibration(bool force, const std::string& who) {
  // Before the job: a change of a camera from now on makes these settings old, and so the acceptance fail.
  const SettingsStore::Version current = store_.current();
  const JointCalibrationJobs::Job job = joint_calibration_jobs_.job(kJointKey);
  if (!job.report || !job.report->found) {
    throw HttpError(409, "there is no new calibration of cameras together to accept");
  }
  if (!force) refuse_acceptance(job.report->accepted, job.report->problems, "the new calibrations are");
  {
    const std::lock_guard lock(calibration_mutex_);
    std::vector<CalibrationChange> changes;
    for (const JointCameraReport& camera : job.report->cameras) {
      changes.push_back(new_calibration(current, camera.id, camera.calibration,
                                        joint_figures_json(*job.report, camera), who));
    }
    put_calibrations_into_force(changes, current, "accepted", who);
    joint_calibration_jobs_.forget(kJointKey, job.report.get());
  }
  return joint_calibration();
}

}  // namespace sslv
