// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/backup_part.h"
#include "services/calibration/calibration_history.h"
#include "services/settings/settings_editor.h"

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace sslv {

/// A calibration to be accepted.
struct NewCalibration {
  int camera_id;
  CameraCalibration calibration;
  Json figures;  // figures of the calibration's report
};

/// Writes calibrations to the settings, with a history that is saved together with the settings or not at
/// all. Thread-safe.
class CalibrationRecords final : public BackupPart {
 public:
  /// Both must outlive this.
  CalibrationRecords(StateFolder& folder, SettingsEditor& settings) : settings_(settings), history_(folder) {}

  /// Newest first, as specified in docs/openapi.json.
  Json history_json(int camera_id) const;

  /// Accepts all or none. `current`: the settings on which the decision was based. Throws HttpError 409 if
  /// they have changed since, 404 for an unknown camera, and the exceptions of SettingsEditor::patch().
  void accept(const std::vector<NewCalibration>& calibrations, const SettingsStore::Version& current,
              const std::string& who);

  /// Reverts the newest record that was not reverted yet: restores the calibration that it replaced. Throws
  /// HttpError 409 if there is none or, unless `force` is set, if the calibration has been changed by other
  /// means since; also throws like accept().
  void revert(int camera_id, bool force, const std::string& who);

  /// Ids of the cameras that were calibrated on a painted field that differs from the current settings.
  std::set<int> find_stale() const;

  // BackupPart
  BackupFiles files(const Config& config) const override;
  bool has(const std::string& name) const override { return name == CalibrationHistory::kFileName; }
  /// No calibration is accepted or reverted until the returned object is destroyed.
  std::unique_ptr<SavedWith> prepare(BackupFiles files) override;

 private:
  class SavedHistory;
  class RestoredHistory;
  struct Change {
    int camera_id;
    Json calibration;
    CalibrationHistory::Records records;  // all records of this camera
  };
  void commit(const std::vector<Change>& changes, const SettingsStore::Version& current,
              const std::string& what, const std::string& who);

  SettingsEditor& settings_;
  mutable std::mutex mutex_;  // guards the history; held during a whole change
  CalibrationHistory history_;
};

}  // namespace sslv
