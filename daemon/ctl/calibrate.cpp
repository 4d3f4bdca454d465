// SPDX-License-Identifier: Apache-2.0
#include "ctl/calibrate.h"

#include "base/params_json.h"
#include "config/backends.h"
#include "config/config.h"
#include "settings/store.h"

#include <chrono>
#include <filesystem>
#include <ostream>
#include <thread>

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

std::string shown(const Json& number, const char* unit, int digits = 2) {
  return number.is_number() ? fmt::format("{:.{}f} {}", number.get<double>(), digits, unit) : "not known";
}

/// Starts a calibration and waits for its report.
Json report_of(const Client& daemon, const std::string& path, const Json& request) {
  Json state = daemon.post(path, request);
  while (state.at("state") == "collecting" || state.at("state") == "solving") {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    state = daemon.get_json(path);
  }
  if (!state.at("report").is_object()) {
    const std::string problem = state.at("problem").get<std::string>();
    throw ClientError(problem.empty() ? fmt::format("the calibration did not finish: it is {}",
                                                    state.at("state").get<std::string>())
                                      : problem);
  }
  return state.at("report");
}

std::string remarks(const Json& report) {
  std::string out;
  for (const Json& note : report.at("notes")) out += "note: " + note.get<std::string>() + "\n";
  for (const Json& problem : report.at("problems")) out += "problem: " + problem.get<std::string>() + "\n";
  return out;
}

}  // namespace

Json calibration_request(const CalibrateWords& words) {
  CalibrationRequest request;
  if (!words.points_file.empty()) {
    request = naming(words.points_file,
                     [&] { return read_calibration_request(read_json_file(words.points_file)); });
  }
  Json json = params_to_json(request);
  if (words.frames) json["frames"] = *words.frames;
  if (words.height_mm) json["height_mm"] = *words.height_mm;
  if (words.height_sigma_mm) json["height_sigma_mm"] = *words.height_sigma_mm;
  if (words.focal_px) json["focal_px"] = *words.focal_px;
  if (!words.plus_x.empty()) json["plus_x"] = words.plus_x;
  if (!words.lines.empty())
    json["lines_measured_to"] = words.lines == "outer-edge" ? "outer_edge" : words.lines;
  read_calibration_request(json);
  return json;
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

Json calibrate_running(const Client& daemon, int camera_id, const Json& request) {
  return report_of(daemon, fmt::format("/api/cameras/{}/calibration", camera_id), request);
}

Json calibrate_together(const Client& daemon, const Json& request) {
  return report_of(daemon, "/api/calibration", request);
}

std::string calibration_text(const Json& report) {
  std::string out;
  if (report.at("found") == true) {
    out += report.at("accepted") == true ? "Calibrated: accepted.\n" : "Calibrated, but NOT accepted.\n";
    out +=
        fmt::format("  lines              {} off on average, {} at most; {:.0f} % of those in view found\n",
                    shown(report.at("rms_px"), "px"), shown(report.at("worst_px"), "px"),
                    100 * report.at("found_share").get<double>());
    out += fmt::format("  expected errors    {} on the floor, {} at 150 mm\n",
                       shown(report.at("expected_on_floor_mm"), "mm"),
                       shown(report.at("expected_at_150_mm"), "mm"));
    out += fmt::format("  height             {}, accurate to {}\n", shown(report.at("height_mm"), "mm", 0),
                       shown(report.at("height_sigma_mm"), "mm", 0));
    if (report.at("moved_on_floor_mm").is_number()) {
      out += fmt::format("  since the previous {} on the floor, {} at 150 mm\n",
                         shown(report.at("moved_on_floor_mm"), "mm", 1),
                         shown(report.at("moved_at_150_mm"), "mm", 1));
    }
  } else {
    out += "NOT calibrated.\n";
  }
  std::size_t number = 0;
  for (const Json& point : report.at("points")) {
    ++number;
    if (point.at("suspect") != true) continue;
    out += fmt::format("looks wrong: point {} at pixel ({:.0f}, {:.0f}), {} from {}\n", number,
                       point.at("x").get<double>(), point.at("y").get<double>(),
                       shown(point.at("off_px"), "px", 0),
                       point.at("name") == "" ? "any given one" : point.at("name").get<std::string>());
  }
  return out + remarks(report);
}

std::string joint_calibration_text(const Json& report) {
  std::string out;
  if (report.at("found") == true) {
    out += report.at("accepted") == true ? "Calibrated together: accepted.\n"
                                         : "Calibrated together, but NOT accepted.\n";
    const auto disagreement = [&](const char* what, const char* key, int count, const char* of) {
      const Json& value = report.at(key);
      out += value.is_object() ? fmt::format("  {:<10}{} apart, before {} ({} {})\n", what,
                                             shown(value.at("after_mm"), "mm"),
                                             shown(value.at("before_mm"), "mm"), count, of)
                               : fmt::format("  {:<10}seen by no two cameras\n", what);
    };
    disagreement("lines", "on_floor", report.at("overlapping_patches").get<int>(), "pieces of line");
    disagreement("robots", "of_robots", report.at("ties").get<int>(), "places");
    for (const Json& camera : report.at("cameras")) {
      out += fmt::format("  camera {:<2} lines {} off; moved {} on the floor, {} at 150 mm\n",
                         camera.at("camera").get<int>(), shown(camera.at("rms_px"), "px"),
                         shown(camera.at("moved_on_floor_mm"), "mm", 1),
                         shown(camera.at("moved_at_150_mm"), "mm", 1));
    }
  } else {
    out += "NOT calibrated.\n";
  }
  return out + remarks(report);
}

}  // namespace sslv
