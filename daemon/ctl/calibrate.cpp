// SPDX-License-Identifier: Apache-2.0
#include "ctl/calibrate.h"

#include "settings/store.h"

#include <chrono>
#include <thread>

#include <fmt/format.h>

namespace sslv {
namespace {

std::string shown(const Json& number, const char* unit, int digits = 2) {
  return number.is_number() ? fmt::format("{:.{}f} {}", number.get<double>(), digits, unit) : "not known";
}

/// The estimate is linear, so large errors are only known to be large.
std::string shown_error(const Json& error_mm) {
  constexpr double kMaxMm = 1000;
  return error_mm.is_number() && error_mm.get<double>() > kMaxMm ? "over 1 m" : shown(error_mm, "mm");
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
  Json json = Json::object();
  if (!words.points_file.empty()) json = read_json_file(words.points_file);
  if (!json.is_object()) json = {{"points", json}};  // the points alone
  if (words.frames) json["frames"] = *words.frames;
  if (words.height_mm) json["height_mm"] = *words.height_mm;
  if (words.height_sigma_mm) json["height_sigma_mm"] = *words.height_sigma_mm;
  if (words.focal_px) json["focal_px"] = *words.focal_px;
  if (!words.plus_x.empty()) json["plus_x"] = words.plus_x;
  if (!words.lines.empty())
    json["lines_measured_to"] = words.lines == "outer-edge" ? "outer_edge" : words.lines;
  return json;
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
    out +=
        report.at("accepted") == true ? "Calibrated: good enough.\n" : "Calibrated, but NOT good enough.\n";
    out +=
        fmt::format("  lines              {} off on average, {} at most; {:.0f} % of those in view found\n",
                    shown(report.at("rms_px"), "px"), shown(report.at("worst_px"), "px"),
                    100 * report.at("found_share").get<double>());
    out += fmt::format("  expected errors    {} on the floor, {} at 150 mm\n",
                       shown_error(report.at("expected_on_floor_mm")),
                       shown_error(report.at("expected_at_150_mm")));
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
    out += report.at("accepted") == true ? "Calibrated together: good enough.\n"
                                         : "Calibrated together, but NOT good enough.\n";
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
