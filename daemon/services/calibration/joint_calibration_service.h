// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/referee_listener.h"
#include "services/access/match_lock.h"
#include "services/calibration/calibration_records.h"
#include "services/calibration/joint_calibration_jobs.h"
#include "services/cameras/cameras.h"
#include "services/service.h"

#include <set>
#include <vector>

namespace sslv {

/// Calibrates several cameras together.
class JointCalibrationService final : public Service, public CameraObserver {
 public:
  /// All must outlive this.
  JointCalibrationService(const Snapshot<Config>& config, SettingsEditor& settings, Cameras& cameras,
                          CalibrationRecords& records, MatchLock& match_lock, const RefereeListener& referee);

  void ask_to_stop() override { jobs_.ask_to_stop(); }
  void cameras_changed(const std::set<int>& camera_ids) noexcept override;
  std::vector<Route> routes() override;

 private:
  Response state() const;
  Response start(const Request& request);
  Response cancel();
  Response accept(const Request& request);
  Response reject();

  const Snapshot<Config>& config_;
  SettingsEditor& settings_;
  CalibrationRecords& records_;
  MatchLock& match_lock_;
  const RefereeListener& referee_;
  JointCalibrationJobs jobs_;  // last: its threads use the cameras
};

}  // namespace sslv
