// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/referee_listener.h"
#include "services/access/match_lock.h"
#include "services/calibration/calibration_jobs.h"
#include "services/calibration/calibration_records.h"
#include "services/cameras/cameras.h"
#include "services/service.h"

#include <memory>
#include <set>
#include <vector>

namespace sslv {

/// Calibrates single cameras, with clicks or without, and accepts, rejects and reverts calibrations.
class CalibrationService final : public Service, public CameraObserver {
 public:
  /// All must outlive this.
  CalibrationService(const Snapshot<Config>& config, SettingsEditor& settings, Cameras& cameras,
                     CalibrationRecords& records, MatchLock& match_lock, const RefereeListener& referee);

  void ask_to_stop() override { jobs_.ask_to_stop(); }
  void cameras_changed(const std::set<int>& camera_ids) noexcept override;

  std::vector<Route> routes() override;
  void report(HealthReport& report) const override;
  std::vector<SupportFile> support_files() const override;
  void each_second() override;

 private:
  Json state_json(int camera_id) const;
  Response start(const Request& request);
  Response cancel(const Request& request);
  Response accept(const Request& request);
  Response reject(const Request& request);
  Response revert(const Request& request);

  const Snapshot<Config>& config_;
  SettingsEditor& settings_;
  Cameras& cameras_;
  CalibrationRecords& records_;
  MatchLock& match_lock_;
  const RefereeListener& referee_;
  Snapshot<std::set<int>> stale_{std::set<int>{}};  // ids of cameras whose calibration is stale
  std::shared_ptr<const Config> looked_at_;  // settings from which stale_ was computed; used in each_second()
  CalibrationJobs jobs_;                     // last: its threads use the members above
};

}  // namespace sslv
