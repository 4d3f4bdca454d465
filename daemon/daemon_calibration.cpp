// SPDX-License-Identifier: Apache-2.0
// How the panel calibrates a camera: docs/api.md.
#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "capture/source.h"
#include "daemon.h"
#include "web/http.h"

#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Place of a camera in the settings. Throws HttpError 404.
std::size_t place_of(const Json& settings, int camera_id) {
  const Json& cameras = settings.at("cameras");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].at("id") == camera_id) return i;
  }
  throw HttpError(404, fmt::format("no camera {}", camera_id));
}

const Json& calibration_in(const Json& settings, int camera_id) {
  return settings.at("cameras")[place_of(settings, camera_id)].at("calibration");
}

/// What the field's sizes mean: as was found, else as was asked for, else as the rules say.
LinesMeasured lines_measured_to(const CalibrationJobs::Job& job) {
  if (job.report) return job.report->measured;
  if (job.order) return job.order->request.lines_measured_to.value_or(LinesMeasured::kToOuterEdge);
  return LinesMeasured::kToOuterEdge;
}

template <class P>
Json json_of(const std::optional<P>& params) {
  return params ? params_to_json(*params) : Json(nullptr);
}

}  // namespace

void Daemon::add_calibration_to(WebHost& host) {
  host.field_view = [this](std::uint32_t id) {
    const auto running = camera(id);
    if (!running) throw HttpError(404, fmt::format("no camera {}", id));
    return field_view_json(running->pipeline().setup()->world.field_view.get());
  };
  host.calibration = [this](std::uint32_t id) { return calibration(static_cast<int>(id)); };
  host.start_calibration = [this](std::uint32_t id, const Json& request, bool force, const std::string& who) {
    return start_calibration(static_cast<int>(id), request, force, who);
  };
  host.cancel_calibration = [this](std::uint32_t id) { return cancel_calibration(static_cast<int>(id)); };
  host.accept_calibration = [this](std::uint32_t id, bool force, const std::string& who) {
    return accept_calibration(static_cast<int>(id), force, who);
  };
  host.reject_calibration = [this](std::uint32_t id) { return reject_calibration(static_cast<int>(id)); };
  host.revert_calibration = [this](std::uint32_t id, bool force, const std::string& who) {
    return revert_calibration(static_cast<int>(id), force, who);
  };
  host.joint_calibration = [this] { return joint_calibration(); };
  host.start_joint_calibration = [this](const Json& request, bool force, const std::string& who) {
    return start_joint_calibration(request, force, who);
  };
  host.cancel_joint_calibration = [this] { return cancel_joint_calibration(); };
  host.accept_joint_calibration = [this](bool force, const std::string& who) {
    return accept_joint_calibration(force, who);
  };
  host.reject_joint_calibration = [this] { return reject_joint_calibration(); };
}

WaitFrame Daemon::frame_waiter() {
  return [this](int camera_id, std::uint64_t newer_than,
                std::chrono::milliseconds timeout) -> std::optional<LentFrame> {
    const auto id = static_cast<std::uint32_t>(camera_id);
    if (!camera(id)) throw CaptureError("the camera is not in the settings any more");
    const auto held = hold_frame(id, newer_than, timeout);
    if (!held) return std::nullopt;
    const Frame& frame = *held->hold->frame;
    return LentFrame{held->version,       held->hold,       frame.image.view(), frame.info.times.t_capture_s,
                     frame.robots.robots, frame.info.whole, frame.info.number,  frame.balls.balls};
  };
}

Json Daemon::calibration(int camera_id) const {
  const auto config = config_.load();
  const CalibrationJobs::Job job = calibration_jobs_.job(camera_id);
  Json out = job_json(job);
  out.update({{"camera", camera_id},
              {"calibration", nullptr},
              {"game_is_running", referee_.game_is_running()},
              {"lines_measured_to", name_of(lines_measured_to(job))},
              {"points", named_points_json(config->field, lines_measured_to(job))},
              {"history", Json::array()}});
  for (const CameraSettings& camera : config->cameras) {
    if (camera.id == camera_id) out["calibration"] = json_of(camera.calibration);
  }
  const std::lock_guard lock(calibration_mutex_);
  const auto& records = calibration_history_.of(camera_id);
  for (auto record = records.rbegin(); record != records.rend(); ++record)
    out["history"].push_back(params_to_json(*record));
  return out;
}

void Daemon::refuse_while_game_runs() const {
  if (match_lock().is_locked()) throw HttpError(423, std::string(kMatchRuns) + ", or use force");
}

void Daemon::refuse_acceptance(bool is_good, const std::vector<std::string>& problems,
                               const std::string& what) const {
  refuse_while_game_runs();
  if (is_good) return;
  throw HttpError(409, fmt::format("{} not good enough: {} Or use force.", what,
                                   problems.empty() ? "see the figures." : problems.front()));
}

Json Daemon::start_calibration(int camera_id, const Json& request, bool force, const std::string& who) {
  CalibrationOrder order{read_calibration_request(request), {}, {}, who, unix_time_s()};
  if (!force) refuse_while_game_runs();
  const auto config = config_.load();
  order.field = config->field;
  for (const CameraSettings& camera : config->cameras) {
    if (camera.id == camera_id) order.previous = camera.calibration;
  }
  if (!calibration_jobs_.start(camera_id, std::move(order))) {
    throw HttpError(409, fmt::format("camera {} is being calibrated already; cancel that first", camera_id));
  }
  log::info("camera {}: calibration started by {}", camera_id, who);
  return calibration(camera_id);
}

Json Daemon::cancel_calibration(int camera_id) {
  if (!calibration_jobs_.cancel(camera_id)) {
    throw HttpError(409, fmt::format("camera {} is not being calibrated", camera_id));
  }
  return calibration(camera_id);
}

Json Daemon::reject_calibration(int camera_id) {
  const CalibrationJobs::Job job = calibration_jobs_.job(camera_id);
  if (!job.order || !calibration_jobs_.forget(camera_id, job.report.get())) {
    throw HttpError(409, fmt::format("camera {} has no finished calibration to reject", camera_id));
  }
  return calibration(camera_id);
}

Json Daemon::accept_calibration(int camera_id, bool force, const std::string& who) {
  // Before the job: a change of the camera from now on makes these settings old, and so the acceptance fail.
  const SettingsStore::Version current = store_.current();
  const CalibrationJobs::Job job = calibration_jobs_.job(camera_id);
  if (!job.report || !job.report->found) {
    throw HttpError(409, fmt::format("camera {} has no new calibration to accept", camera_id));
  }
  if (!force)
    refuse_acceptance(job.report->accepted, job.report->problems,
                      fmt::format("camera {}'s new calibration is", camera_id));
  {
    const std::lock_guard lock(calibration_mutex_);
    put_calibrations_into_force(
        {new_calibration(current, camera_id, job.report->calibration, figures_json(*job.report), who)},
        current, "accepted", who);
    calibration_jobs_.forget(camera_id, job.report.get());
  }
  return calibration(camera_id);
}

Json Daemon::revert_calibration(int camera_id, bool force, const std::string& who) {
  if (!force) refuse_while_game_runs();
  {
    const std::lock_guard lock(calibration_mutex_);
    const SettingsStore::Version current = store_.current();
    CalibrationHistory::Records records = calibration_history_.of(camera_id);
    CalibrationRecord* newest = newest_in_force(records);
    if (newest == nullptr) {
      throw HttpError(409, fmt::format("camera {} has no earlier calibration to go back to", camera_id));
    }
    if (!force && calibration_in(current.settings, camera_id) != params_to_json(newest->calibration)) {
      throw HttpError(409,
                      fmt::format("camera {}'s calibration was changed in another way since the last one "
                                  "was accepted; to go back all the same, use force",
                                  camera_id));
    }
    newest->reverted_s = unix_time_s();
    newest->reverted_by = who;
    const Json back = json_of(newest->replaced);
    put_calibrations_into_force({{camera_id, back, std::move(records)}}, current, "reverted", who);
  }
  return calibration(camera_id);
}

Daemon::CalibrationChange Daemon::new_calibration(const SettingsStore::Version& current, int camera_id,
                                                  const CameraCalibration& calibration, Json figures,
                                                  const std::string& who) const {
  const Json& before = calibration_in(current.settings, camera_id);
  CalibrationChange out{camera_id, params_to_json(calibration), calibration_history_.of(camera_id)};
  CalibrationRecord& record = out.records.emplace_back();
  record.time_s = unix_time_s();
  record.who = who;
  record.figures = std::move(figures);
  record.calibration = calibration;
  if (!before.is_null()) record.replaced = params_from_json<CameraCalibration>(before, "");
  return out;
}

void Daemon::put_calibrations_into_force(const std::vector<CalibrationChange>& changes,
                                         const SettingsStore::Version& current, const std::string& what,
                                         const std::string& who) {
  Json patch = Json::array();
  CalibrationHistory::ByCamera records, old_records;
  std::string cameras;
  for (const CalibrationChange& change : changes) {
    const std::string path =
        fmt::format("/cameras/{}/calibration", place_of(current.settings, change.camera_id));
    patch.push_back({{"op", "replace"}, {"path", path}, {"value", change.calibration}});
    records[change.camera_id] = change.records;
    old_records[change.camera_id] = calibration_history_.of(change.camera_id);
    cameras += fmt::format("{}camera {}'s", cameras.empty() ? "" : ", ", change.camera_id);
  }
  bool is_recorded = false;
  try {
    const SettingsEdit edit{who, current.revision, "calibration " + what};
    const auto version = store_.patch(patch, edit, [&](const Json& next) {
      auto put_into_force = prepare(next);
      // Before the settings: whatever happens in between, what is replaced is on disk.
      calibration_history_.set(records);
      is_recorded = true;
      return put_into_force;
    });
    log::info("settings revision {} saved, {} calibration {} by {}", version.revision, cameras, what, who);
  } catch (const std::exception&) {
    try {
      if (is_recorded) calibration_history_.set(old_records);
    } catch (const StorageError& error) {
      log::error("calibrations that were refused stay in the history: {}", error.what());
    }
    throw;
  }
}

}  // namespace sslv
