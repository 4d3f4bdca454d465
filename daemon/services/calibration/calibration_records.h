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

/// A calibration that is to be accepted.
struct NewCalibration {
  int camera_id;
  CameraCalibration calibration;
  Json figures;  // of its report
};

/// Puts calibrations into the settings, with a history of them that is saved with the settings or not at all.
/// May be used from any thread.
class CalibrationRecords final : public BackupPart {
 public:
  /// Both must outlive this.
  CalibrationRecords(StateFolder& folder, SettingsEditor& settings) : settings_(settings), history_(folder) {}

  /// Newest first, as docs/openapi.json has them.
  Json history_json(int camera_id) const;

  /// All or none. `current`: the settings that the decision was made on; throws HttpError 409 when they have
  /// changed since, 404 without such a camera, and what SettingsEditor::patch() throws.
  void accept(const std::vector<NewCalibration>& calibrations, const SettingsStore::Version& current,
              const std::string& who);

  /// Back to what the newest record that was not taken back replaced. Throws HttpError 409 when there is
  /// none, or when the calibration was changed in another way since, unless forced; and as accept() does.
  void revert(int camera_id, bool force, const std::string& who);

  /// Ids of the cameras that were calibrated on another field than that of the settings.
  std::set<int> find_stale() const;

  // BackupPart
  BackupFiles files(const Config& config) const override;
  bool has(const std::string& name) const override { return name == CalibrationHistory::kFileName; }
  /// No calibration is accepted or reverted until what is returned goes.
  std::unique_ptr<SavedWith> prepare(BackupFiles files) override;

 private:
  class SavedHistory;
  class RestoredHistory;
  struct Change {
    int camera_id;
    Json calibration;
    CalibrationHistory::Records records;  // all of the camera's
  };
  void commit(const std::vector<Change>& changes, const SettingsStore::Version& current,
              const std::string& what, const std::string& who);

  SettingsEditor& settings_;
  mutable std::mutex mutex_;  // guards the history; held during a whole change
  CalibrationHistory history_;
};

}  // namespace sslv
