// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibration_json.h"

#include "base/params_json.h"

#include <cmath>

namespace sslv {
namespace {

/// Replaces NaN and infinity, which JSON cannot represent, with null, without relying on the serializer.
void drop_non_numbers(Json& json) {
  if (json.is_number_float() && !std::isfinite(json.get<double>())) {
    json = nullptr;
  } else if (json.is_structured()) {
    for (Json& one : json) drop_non_numbers(one);
  }
}

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json camera_json(const LensCamera& camera) {
  return {{"width_px", camera.width},
          {"height_px", camera.height},
          {"focal_px", camera.focal_px},
          {"center_x_px", camera.center_x},
          {"center_y_px", camera.center_y},
          {"k1", camera.k1},
          {"k2", camera.k2},
          {"x_mm", camera.position_mm.x()},
          {"y_mm", camera.position_mm.y()},
          {"z_mm", camera.position_mm.z()}};
}

Json line_json(const LineFigure& line) {
  return {{"name", line.name},     {"patches", line.patches},   {"expected", line.expected},
          {"rms_px", line.rms_px}, {"worst_px", line.worst_px}, {"rms_mm", line.rms_mm}};
}

Json point_json(const ClickFigure& click) {
  return {{"name", click.name},
          {"x", click.pixel.x()},
          {"y", click.pixel.y()},
          {"field_x", click.place_mm.x()},
          {"field_y", click.place_mm.y()},
          {"off_px", click.off_px},
          {"off_mm", click.off_mm},
          {"suspect", click.suspect}};
}

Json error_json(const ExpectedError& error) {
  return {{"x_mm", error.place_mm.x()},
          {"y_mm", error.place_mm.y()},
          {"on_floor_mm", error.on_floor_mm},
          {"at_150_mm", error.at_150_mm}};
}

template <class T>
Json list_json(const std::vector<T>& values, Json (*one)(const T&)) {
  Json out = Json::array();
  for (const T& value : values) out.push_back(one(value));
  return out;
}

}  // namespace

CalibrationRequest read_calibration_request(const Json& json) {
  auto request = params_from_json<CalibrationRequest>(json.is_array() ? Json{{"points", json}} : json, "");
  for (std::size_t i = 0; i < request.points.size(); ++i) {
    const CalibrationPoint& point = request.points[i];
    const std::string path = "/points/" + std::to_string(i);
    if (!point.x) throw SettingsError(path + "/x: is missing; expected a pixel position");
    if (!point.y) throw SettingsError(path + "/y: is missing; expected a pixel position");
    if (point.field_x.has_value() != point.field_y.has_value()) {
      throw SettingsError(path + (point.field_x ? "/field_y" : "/field_x") +
                          ": is missing; expected both field_x and field_y, or neither");
    }
  }
  return request;
}

CalibrationTask make_task(const CalibrationRequest& request, const FieldSize& field,
                          std::optional<CameraCalibration> previous) {
  CalibrationTask task;
  task.field = field;
  task.measured = request.lines_measured_to;
  for (const CalibrationPoint& point : request.points) {
    ClickedPoint& click = task.clicks.emplace_back();
    click.pixel = {point.x.value(), point.y.value()};
    click.name = point.name;
    if (point.field_x) click.place_mm.emplace(*point.field_x, *point.field_y);
  }
  task.click_sigma_px = request.click_sigma_px;
  task.plus_x = request.plus_x.value_or(PlusX::kUnknown);
  task.height_mm = request.height_mm;
  task.height_sigma_mm = request.height_sigma_mm;
  task.focal_px = request.focal_px;
  task.previous = previous;
  return task;
}

const char* name_of(LinesMeasured measured) {
  return measured == LinesMeasured::kToOuterEdge ? "outer_edge" : "middle";
}

Json report_json(const CalibrationReport& report) {
  Json out{{"found", report.found},
           {"accepted", report.accepted},
           {"calibration", report.found ? params_to_json(report.calibration) : Json(nullptr)},
           {"camera", report.found ? camera_json(report.camera) : Json(nullptr)},
           {"lines_measured_to", name_of(report.measured)},
           {"rms_px", report.rms_px},
           {"worst_px", report.worst_px},
           {"rms_mm", report.rms_mm},
           {"worst_mm", report.worst_mm},
           {"found_share", report.found_share},
           {"unexplained_share", report.unexplained_share},
           {"coverage", report.coverage},
           {"condition", report.condition},
           {"expected_on_floor_mm", report.expected_on_floor_mm},
           {"expected_at_150_mm", report.expected_at_150_mm},
           {"height_mm", report.height_mm},
           {"height_sigma_mm", report.height_sigma_mm},
           {"lens_rms_mm", report.lens_rms_mm},
           {"lens_worst_mm", report.lens_worst_mm},
           {"moved_on_floor_mm", or_null(report.moved_on_floor_mm)},
           {"moved_at_150_mm", or_null(report.moved_at_150_mm)},
           {"lines", list_json(report.line_figures, line_json)},
           {"points", list_json(report.click_figures, point_json)},
           {"control_points", list_json(report.control_points, point_json)},
           {"error_map", list_json(report.error_map, error_json)},
           {"held", report.held},
           {"notes", report.notes},
           {"problems", report.problems}};
  drop_non_numbers(out);
  return out;
}

Json figures_json(const CalibrationReport& report) {
  Json out{{"accepted", report.accepted},
           {"rms_px", report.rms_px},
           {"worst_px", report.worst_px},
           {"rms_mm", report.rms_mm},
           {"worst_mm", report.worst_mm},
           {"found_share", report.found_share},
           {"coverage", report.coverage},
           {"expected_on_floor_mm", report.expected_on_floor_mm},
           {"expected_at_150_mm", report.expected_at_150_mm},
           {"height_mm", report.height_mm},
           {"height_sigma_mm", report.height_sigma_mm},
           {"moved_on_floor_mm", or_null(report.moved_on_floor_mm)},
           {"lines", list_json(report.line_figures, line_json)},
           {"points", list_json(report.click_figures, point_json)}};
  drop_non_numbers(out);
  return out;
}

Json named_points_json(const FieldSize& field, LinesMeasured measured) {
  Json out = Json::array();
  const auto curves = painted_curves(field, measured);
  for (const NamedPoint& point : named_points(curves)) {
    out.push_back({{"name", point.name}, {"field_x", point.place_mm.x()}, {"field_y", point.place_mm.y()}});
  }
  return out;
}

}  // namespace sslv
