// SPDX-License-Identifier: Apache-2.0
#include "lab/calibrate.h"

#include "base/params_json.h"
#include "config/backends.h"
#include "config/config.h"
#include "settings/store.h"

#include <chrono>
#include <filesystem>
#include <ostream>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Runs `act`; if it refuses a value, the error also names the file.
template <class Act>
auto naming(const std::string& file, Act act) {
  try {
    return act();
  } catch (const SettingsError& error) {
    const std::string what = error.what();
    throw SettingsError(what.starts_with(file) ? what : file + ": " + what);
  }
}

}  // namespace

CalibrationRequest checked_request(const CalibrateWords& words) {
  if (!words.points_file.empty())
    naming(words.points_file, [&] { return read_calibration_request(read_json_file(words.points_file)); });
  return read_calibration_request(calibration_request(words));
}

CalibrationReport calibrate_recording(const CalibrateInput& input, const CalibrationRequest& request,
                                      const FieldSize& field, std::optional<CameraCalibration> previous,
                                      std::ostream& problems) {
  const Backend& files = find_backend("files", "--input");
  Json source{{"path", input.path}, {"frame_rate_hz", 0}, {"loop", false}};
  if (!input.pixel_format.empty()) {
    source.update(
        Json{{"pixel_format", input.pixel_format}, {"width", input.width}, {"height", input.height}});
  }
  const auto recording = files.open(files.complete(source, "--input"), {});
  MeanPicture mean;
  bool ended = false;
  while (!ended && mean.frames() < request.frames) {
    CapturedImage captured;
    std::string problem;
    switch (recording->next(captured, problem, std::chrono::seconds(10))) {
      case CaptureStatus::kImage:
        if (!mean.add(captured.image.view())) {
          problems << captured.name << ": has no colours, or another size than the first; it was left out\n";
        }
        break;
      case CaptureStatus::kIncomplete: problems << problem << '\n'; break;
      case CaptureStatus::kTimeout: break;
      case CaptureStatus::kEnd: ended = true; break;
      case CaptureStatus::kLost: throw CaptureError(problem);
    }
  }
  if (mean.frames() == 0) throw CaptureError(input.path + ": holds no image that can be used");
  return calibrate(mean, make_task(request, field, previous));
}

FieldSize field_named(const std::string& name_or_file) {
  std::error_code error;
  const bool is_file =
      name_or_file.ends_with(".json") || std::filesystem::is_regular_file(name_or_file, error);
  if (!is_file) return field_preset(name_or_file, "--field");
  return naming(name_or_file, [&] {
    return read_config(up_to_date(read_json_file(name_or_file), settings_migrations())).field;
  });
}

CameraCalibration read_calibration(const std::string& file) {
  return naming(file, [&] {
    const auto calibration = params_from_json<CameraCalibration>(read_json_file(file), "");
    CameraModel(calibration, "calibration");
    return calibration;
  });
}

}  // namespace sslv
