// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_history.h"

#include "base/log.h"
#include "base/params_json.h"
#include "settings/state_folder.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace sslv {
namespace {

constexpr std::ptrdiff_t kMaxRecords = 20;

struct CameraRecords {
  int camera = 0;
  CalibrationHistory::Records records;
  static constexpr auto fields() {
    return std::tuple{number("camera", &CameraRecords::camera, 0, 255, "", "its id"),
                      list("records", &CameraRecords::records, "oldest first")};
  }
};

struct File {
  std::vector<CameraRecords> cameras;
  static constexpr auto fields() {
    return std::tuple{list("cameras", &File::cameras, "each with its records")};
  }
};

}  // namespace

CalibrationHistory::CalibrationHistory(StateFolder& folder)
    : folder_(folder), file_(folder.path() / "calibrations.json") {
  remove_leftover(file_);
  std::error_code ignored;
  if (!std::filesystem::exists(file_, ignored)) return;
  try {
    for (CameraRecords& camera : params_from_json<File>(read_json_file(file_), "").cameras)
      records_[camera.camera] = std::move(camera.records);
  } catch (const SettingsError& error) {
    log::error("the history of calibrations cannot be used and was set aside as {}: {}",
               set_aside(file_).string(), error.what());
    records_.clear();
  }
}

const CalibrationHistory::Records& CalibrationHistory::of(int camera_id) const {
  static const Records kNone;
  const auto found = records_.find(camera_id);
  return found == records_.end() ? kNone : found->second;
}

void CalibrationHistory::set(const ByCamera& records) {
  auto next = records_;
  for (const auto& [id, of_camera] : records) {
    const auto count = static_cast<std::ptrdiff_t>(of_camera.size());
    next[id].assign(of_camera.end() - std::min(count, kMaxRecords), of_camera.end());
  }
  File file;
  for (const auto& [id, of_camera] : next) file.cameras.push_back({id, of_camera});
  folder_.write(file_, params_to_json(file).dump(2) + "\n");
  records_ = std::move(next);
}

CalibrationRecord* newest_in_force(CalibrationHistory::Records& records) {
  const auto found = std::find_if(records.rbegin(), records.rend(),
                                  [](const CalibrationRecord& record) { return !record.reverted_s; });
  return found == records.rend() ? nullptr : &*found;
}

}  // namespace sslv
