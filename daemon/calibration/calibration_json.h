// SPDX-License-Identifier: Apache-2.0
#pragma once

// Request and report of a camera's calibration as JSON, for the panel's API and ssl-visionctl.

#include "base/json.h"
#include "base/params_json.h"
#include "calibration/calibrate.h"

#include <array>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace sslv {

inline constexpr std::array<Choice<PlusX>, 4> kPlusXChoices{
    {{"right", PlusX::kRight}, {"left", PlusX::kLeft}, {"up", PlusX::kUp}, {"down", PlusX::kDown}}};

struct CalibrationPoint {
  std::optional<double> x, y;
  std::string name;
  std::optional<double> field_x, field_y;

  static constexpr auto fields() {
    using P = CalibrationPoint;
    constexpr double kFar = 100'000;
    return std::tuple{
        number("x", &P::x, -1.0, 16384.0, "px", "position in the image"),
        number("y", &P::y, -1.0, 16384.0, "px", "position in the image"),
        text("name", &P::name, "name of this point of the field; empty: unknown"),
        number("field_x", &P::field_x, -kFar, kFar, "mm", "position on the field, instead of a name"),
        number("field_y", &P::field_y, -kFar, kFar, "mm", "position on the field, instead of a name"),
    };
  }
};

struct CalibrationRequest {
  static constexpr std::size_t kMaxPoints = 100;
  std::vector<CalibrationPoint> points;
  int frames = 10;
  std::optional<double> height_mm;
  double height_sigma_mm = 20;
  std::optional<double> focal_px;
  std::optional<PlusX> plus_x;
  std::optional<LinesMeasured> lines_measured_to;
  double click_sigma_px = 3;

  static constexpr auto fields() {
    using R = CalibrationRequest;
    return std::tuple{
        list("points", &R::points, "corners and crossings of lines that a user clicked, in any order",
             kMaxPoints),
        number("frames", &R::frames, 1, 100, "", "number of images to average"),
        number("height_mm", &R::height_mm, 100.0, 100'000.0, "mm",
               "height of the camera above the floor, if measured"),
        number("height_sigma_mm", &R::height_sigma_mm, 0.1, 10'000.0, "mm", "accuracy of that height"),
        number("focal_px", &R::focal_px, 1.0, 1e6, "px", "focal length of the lens, if known"),
        choice("plus_x", &R::plus_x, kPlusXChoices,
               "the side of the image where the +x half of the field lies; null: unknown"),
        choice("lines_measured_to", &R::lines_measured_to, kLinesMeasuredChoices,
               "the reference of the field's sizes; null: the lines' middle, unless their outer edge fits "
               "the image clearly better"),
        number("click_sigma_px", &R::click_sigma_px, 0.1, 100.0, "px", "accuracy of the points"),
    };
  }
};

/// Reads a request, or a bare list of points. Throws SettingsError for invalid values.
CalibrationRequest read_calibration_request(const Json& json);

/// Converts a request to the engine's task. `previous`: the current calibration.
CalibrationTask make_task(const CalibrationRequest& request, const FieldSize& field,
                          std::optional<CameraCalibration> previous);

/// The whole report, as specified in docs/openapi.json. NaN and infinity become null.
Json report_json(const CalibrationReport& report);

/// The figures that the history stores with a calibration.
Json figures_json(const CalibrationReport& report);

/// The name used in requests.
const char* name_of(LinesMeasured measured);

/// The points of the field that a request may name, with their positions (mm, middle of the paint).
Json named_points_json(const FieldSize& field, LinesMeasured measured);

}  // namespace sslv
