// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_records.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "services/calibration/calibration_age.h"
#include "web/route.h"

#include <cstddef>
#include <exception>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Index of a camera in the settings. Throws HttpError 404.
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

}  // namespace

/// Saves new records of some cameras together with the settings. The mutex must be held.
class CalibrationRecords::SavedHistory final : public SavedWith {
 public:
  SavedHistory(CalibrationHistory& history, CalibrationHistory::ByCamera records)
      : history_(history), records_(std::move(records)) {
    for (const auto& [id, unused] : records_) old_records_[id] = history_.of(id);
  }
  void save() override { history_.set(records_); }
  void take_back() noexcept override {
    try {
      history_.set(old_records_);
    } catch (const std::exception& error) {
      log::error("refused calibrations were not removed from the history: {}", error.what());
    }
  }

 private:
  CalibrationHistory& history_;
  const CalibrationHistory::ByCamera records_;
  CalibrationHistory::ByCamera old_records_;
};

/// Replaces the whole history with the history in a backup. Holds the mutex.
class CalibrationRecords::RestoredHistory final : public SavedWith {
 public:
  RestoredHistory(std::unique_lock<std::mutex> lock, CalibrationHistory& history,
                  std::optional<std::string> text)
      : lock_(std::move(lock)),
        history_(history),
        records_(records_in(text)),
        old_(records_in(history.to_text())) {}
  void save() override { history_.replace(records_); }
  void take_back() noexcept override {
    try {
      history_.replace(old_);
    } catch (const std::exception& error) {
      log::error("calibrations of a refused backup were not removed from the history: {}", error.what());
    }
  }

 private:
  static std::optional<CalibrationHistory::ByCamera> records_in(const std::optional<std::string>& text) {
    return text ? std::optional(CalibrationHistory::from_text(*text)) : std::nullopt;
  }

  const std::unique_lock<std::mutex> lock_;
  CalibrationHistory& history_;
  const std::optional<CalibrationHistory::ByCamera> records_, old_;
};

BackupFiles CalibrationRecords::files(const Config& /*config*/) const {
  const std::lock_guard lock(mutex_);
  const auto text = history_.to_text();
  return text ? BackupFiles{{CalibrationHistory::kFileName, *text}} : BackupFiles{};
}

std::unique_ptr<SavedWith> CalibrationRecords::prepare(BackupFiles files) {
  const auto found = files.find(CalibrationHistory::kFileName);
  return std::make_unique<RestoredHistory>(
      std::unique_lock(mutex_), history_,
      found == files.end() ? std::nullopt : std::optional(std::move(found->second)));
}

Json CalibrationRecords::history_json(int camera_id) const {
  Json out = Json::array();
  const std::lock_guard lock(mutex_);
  const auto& records = history_.of(camera_id);
  for (auto record = records.rbegin(); record != records.rend(); ++record)
    out.push_back(params_to_json(*record));
  return out;
}

void CalibrationRecords::accept(const std::vector<NewCalibration>& calibrations,
                                const SettingsStore::Version& current, const std::string& who) {
  const std::lock_guard lock(mutex_);
  std::vector<Change> changes;
  for (const NewCalibration& one : calibrations) {
    const Json& before = calibration_in(current.settings, one.camera_id);
    Change change{one.camera_id, params_to_json(one.calibration), history_.of(one.camera_id)};
    CalibrationRecord& record = change.records.emplace_back();
    record.time_s = unix_time_s();
    record.who = who;
    record.figures = one.figures;
    record.calibration = one.calibration;
    if (!before.is_null()) record.replaced = params_from_json<CameraCalibration>(before, "");
    changes.push_back(std::move(change));
  }
  commit(changes, current, "accepted", who);
}

void CalibrationRecords::revert(int camera_id, bool force, const std::string& who) {
  const std::lock_guard lock(mutex_);
  const SettingsStore::Version current = settings_.current();
  CalibrationHistory::Records records = history_.of(camera_id);
  CalibrationRecord* newest = newest_in_force(records);
  if (newest == nullptr)
    throw HttpError(409, fmt::format("camera {} has no earlier calibration to revert to", camera_id));
  if (!force && calibration_in(current.settings, camera_id) != params_to_json(newest->calibration)) {
    throw HttpError(409, fmt::format("camera {}'s calibration was changed by other means after the last one "
                                     "was accepted; you can revert anyway (force)",
                                     camera_id));
  }
  newest->reverted_s = unix_time_s();
  newest->reverted_by = who;
  Json back = newest->replaced ? params_to_json(*newest->replaced) : Json(nullptr);
  commit({{camera_id, std::move(back), std::move(records)}}, current, "reverted", who);
}

void CalibrationRecords::commit(const std::vector<Change>& changes, const SettingsStore::Version& current,
                                const std::string& what, const std::string& who) {
  Json patch = Json::array();
  CalibrationHistory::ByCamera records;
  std::string cameras;
  for (const Change& change : changes) {
    const std::string path =
        fmt::format("/cameras/{}/calibration", place_of(current.settings, change.camera_id));
    patch.push_back({{"op", "replace"}, {"path", path}, {"value", change.calibration}});
    records[change.camera_id] = change.records;
    cameras += fmt::format("{}camera {}'s", cameras.empty() ? "" : ", ", change.camera_id);
  }
  SavedHistory history(history_, std::move(records));
  const auto version = settings_.patch(patch, {who, current.revision, "calibration " + what}, &history);
  log::info("settings revision {} saved, {} calibration {} by {}", version.revision, cameras, what, who);
}

std::set<int> CalibrationRecords::find_stale() const {
  std::set<int> stale;
  const std::lock_guard lock(mutex_);
  const Json settings = settings_.current().settings, steps = settings_.history();
  for (const Json& camera : settings.at("cameras")) {
    const int id = camera.at("id").get<int>();
    CalibrationHistory::Records records = history_.of(id);
    const CalibrationRecord* newest = newest_in_force(records);
    // The field of a calibration that was set by other means is unknown.
    if (newest == nullptr || camera.at("calibration") != params_to_json(newest->calibration)) continue;
    if (field_changed_since(newest->time_s, settings, steps)) stale.insert(id);
  }
  return stale;
}

}  // namespace sslv
