// SPDX-License-Identifier: Apache-2.0
// How the panel calibrates a camera: docs/api.md.
#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
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
}

std::optional<CalibrationJobs::LentFrame> Daemon::wait_frame(int camera_id, std::uint64_t newer_than,
                                                             std::chrono::milliseconds timeout) {
  auto view = wait_view(static_cast<std::uint32_t>(camera_id), newer_than, timeout);
  if (!view) return std::nullopt;
  return CalibrationJobs::LentFrame{view->version, std::move(view->hold), view->image};
}

Json Daemon::calibration(int camera_id) const {
  const auto config = config_.load();
  const CalibrationJobs::Job job = calibration_jobs_.job(camera_id);
  Json out{{"camera", camera_id},
           {"state", name_of(job.state)},
           {"frames_taken", job.frames},
           {"problem", job.problem},
           {"started", job.order ? Json(job.order->time_s) : Json(nullptr)},
           {"who", job.order ? job.order->who : ""},
           {"request", job.order ? params_to_json(job.order->request) : Json(nullptr)},
           {"report", job.report ? report_json(*job.report) : Json(nullptr)},
           {"calibration", nullptr},
           {"game_is_running", referee_.game_is_running()},
           {"lines_measured_to", name_of(lines_measured_to(job))},
           {"points", named_points_json(config->field, lines_measured_to(job))},
           {"history", Json::array()}};
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
  if (!referee_.game_is_running()) return;
  throw HttpError(423, "the game is running, as the game controller says: wait for HALT, or use force");
}

Json Daemon::start_calibration(int camera_id, const Json& request, bool force, const std::string& who) {
  CalibrationJobs::Order order{read_calibration_request(request), {}, {}, who, unix_time_s()};
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
  if (!force) {
    refuse_while_game_runs();
    if (!job.report->accepted) {
      throw HttpError(
          409, fmt::format("camera {}'s new calibration is not good enough: {} Or use force.", camera_id,
                           job.report->problems.empty() ? "see its figures." : job.report->problems.front()));
    }
  }
  {
    const std::lock_guard lock(calibration_mutex_);
    const Json& before = calibration_in(current.settings, camera_id);
    CalibrationRecord record;
    record.time_s = unix_time_s();
    record.who = who;
    record.figures = figures_json(*job.report);
    record.calibration = job.report->calibration;
    if (!before.is_null()) record.replaced = params_from_json<CameraCalibration>(before, "");
    CalibrationHistory::Records records = calibration_history_.of(camera_id);
    records.push_back(std::move(record));
    put_calibration_into_force(camera_id, params_to_json(job.report->calibration), std::move(records),
                               current, "accepted by " + who);
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
    put_calibration_into_force(camera_id, back, std::move(records), current, "reverted by " + who);
  }
  return calibration(camera_id);
}

void Daemon::put_calibration_into_force(int camera_id, const Json& calibration,
                                        CalibrationHistory::Records records,
                                        const SettingsStore::Version& current, const std::string& what) {
  const std::string path = fmt::format("/cameras/{}/calibration", place_of(current.settings, camera_id));
  const Json patch = Json::array({{{"op", "replace"}, {"path", path}, {"value", calibration}}});
  const CalibrationHistory::Records old_records = calibration_history_.of(camera_id);
  bool is_recorded = false;
  try {
    const auto version = store_.patch(patch, current.revision, [&](const Json& next) {
      auto put_into_force = prepare(next);
      // Before the settings: whatever happens in between, what is replaced is on disk.
      calibration_history_.set(camera_id, std::move(records));
      is_recorded = true;
      return put_into_force;
    });
    log::info("settings revision {} saved, camera {}'s calibration {}", version.revision, camera_id, what);
  } catch (const std::exception&) {
    if (is_recorded) calibration_history_.set(camera_id, old_records);
    throw;
  }
}

}  // namespace sslv
