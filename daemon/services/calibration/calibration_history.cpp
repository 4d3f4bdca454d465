// SPDX-License-Identifier: Apache-2.0
#include "services/calibration/calibration_history.h"

#include "base/log.h"
#include "base/params_json.h"
#include "settings/state_folder.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <system_error>
#include <utility>

#include <fmt/format.h>

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

struct HistoryFile {
  std::vector<CameraRecords> cameras;
  static constexpr auto fields() {
    return std::tuple{list("cameras", &HistoryFile::cameras, "each with its records")};
  }
};

std::string history_text(const CalibrationHistory::ByCamera& records) {
  HistoryFile file;
  for (const auto& [id, of_camera] : records) file.cameras.push_back({id, of_camera});
  return json_text(params_to_json(file), 2) + "\n";
}

CalibrationHistory::ByCamera history_in(const Json& json) {
  CalibrationHistory::ByCamera records;
  for (CameraRecords& camera : params_from_json<HistoryFile>(json, "").cameras)
    records[camera.camera] = std::move(camera.records);
  return records;
}

}  // namespace

CalibrationHistory::CalibrationHistory(StateFolder& folder)
    : folder_(folder), file_(folder.path() / kFileName) {
  remove_leftover(file_);
  std::error_code ignored;
  if (!std::filesystem::exists(file_, ignored)) return;
  try {
    records_ = history_in(read_json_file(file_));
  } catch (const SettingsError& error) {
    log::error("the history of calibrations cannot be used and was set aside as {}: {}",
               set_aside(file_).string(), error.what());
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
  replace(std::move(next));
}

void CalibrationHistory::replace(std::optional<ByCamera> records) {
  records ? folder_.write(file_, history_text(*records)) : remove_file(file_);
  records_ = std::move(records).value_or(ByCamera{});
}

std::optional<std::string> CalibrationHistory::to_text() const {
  std::error_code ignored;
  if (records_.empty() && !std::filesystem::exists(file_, ignored)) return std::nullopt;
  return history_text(records_);
}

CalibrationHistory::ByCamera CalibrationHistory::from_text(const std::string& text) {
  const auto refuse = [](const char* why) { throw SettingsError(fmt::format("{}: {}", kFileName, why)); };
  ByCamera records;
  try {
    records = history_in(parse_bounded_json(text));
  } catch (const SettingsError& error) {
    refuse(error.what());
  } catch (const std::exception& error) {  // not JSON
    refuse(error.what());
  }
  for (const auto& [id, of_camera] : records) {
    if (std::ssize(of_camera) > kMaxRecords) refuse("a camera has more than 20 records");
  }
  return records;
}

CalibrationRecord* newest_in_force(CalibrationHistory::Records& records) {
  const auto found = std::find_if(records.rbegin(), records.rend(),
                                  [](const CalibrationRecord& record) { return !record.reverted_s; });
  return found == records.rend() ? nullptr : &*found;
}

}  // namespace sslv
