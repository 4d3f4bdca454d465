// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "base/params.h"
#include "geometry/camera_model.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace sslv {

class StateFolder;

/// A calibration that was applied.
struct CalibrationRecord {
  double time_s = 0;
  std::string who;                // the client's address
  Json figures = Json::object();  // figures of the calibration's report
  CameraCalibration calibration;
  std::optional<CameraCalibration> replaced;  // calibration in effect before
  std::optional<double> reverted_s;           // when `replaced` was restored
  std::string reverted_by;

  static constexpr auto fields() {
    using R = CalibrationRecord;
    constexpr double kFarFuture = 1e12;
    return std::tuple{
        number("time", &R::time_s, 0.0, kFarFuture, "s", "Unix time"),
        text("who", &R::who, "the client's address"),
        object("figures", &R::figures, "of its report"),
        group("calibration", &R::calibration, "the calibration that was applied"),
        group("replaced", &R::replaced, "the calibration before it; null: none"),
        number("reverted", &R::reverted_s, 0.0, kFarFuture, "s", "Unix time when it was taken back"),
        text("reverted_by", &R::reverted_by, "the client's address"),
    };
  }
};

/// The latest calibrations of every camera, oldest first, stored in a file. Not thread-safe.
class CalibrationHistory {
 public:
  using Records = std::vector<CalibrationRecord>;
  using ByCamera = std::map<int, Records>;

  /// Stored in calibrations.json. A file that cannot be used is set aside (renamed *.rejected).
  explicit CalibrationHistory(StateFolder& folder);

  /// The records of a camera; empty when there are none.
  const Records& of(int camera_id) const;

  /// Replaces these cameras' records, on disk first; keeps only the newest records of each camera. Throws
  /// StorageError, with nothing changed.
  void set(const ByCamera& records);
  void set(int camera_id, Records records) { set({{camera_id, std::move(records)}}); }

  // The whole history as a file of a backup.
  static constexpr const char* kFileName = "calibrations.json";
  /// The content of the file; nullopt if there is neither a file nor a record.
  std::optional<std::string> to_text() const;
  /// Throws SettingsError with a message that begins with the file's name.
  static ByCamera from_text(const std::string& text);
  /// Replaces the whole history, on disk first; nullopt removes the file. Throws StorageError, with nothing
  /// changed.
  void replace(std::optional<ByCamera> records);

 private:
  StateFolder& folder_;
  const std::filesystem::path file_;
  ByCamera records_;
};

/// The newest record that was not reverted; nullptr when there is none.
CalibrationRecord* newest_in_force(CalibrationHistory::Records& records);

}  // namespace sslv
