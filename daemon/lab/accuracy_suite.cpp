// SPDX-License-Identifier: Apache-2.0
#include "base/params_json.h"
#include "capture/simulator/simulator.h"
#include "image/pixel_format_names.h"
#include "lab/accuracy_trial.h"
#include "pipeline/pipeline.h"
#include "settings/store.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Resolution on the floor in the middle of the image.
double px_per_mm_of(const CameraCalibration& c) {
  const Eigen::Vector2d middle(c.pixel_image_width / 2.0, c.pixel_image_height / 2.0);
  return 1 / std::sqrt(CameraModel(c).mm2_per_px(middle, 0));
}

/// The same camera with a sensor of another resolution.
CameraCalibration scaled(CameraCalibration c, double scale) {
  const auto even = [&](int size) { return 2 * static_cast<int>(std::lround(size * scale / 2)); };
  c.focal_length *= scale;
  c.principal_point_x = (c.principal_point_x + 0.5) * scale - 0.5;
  c.principal_point_y = (c.principal_point_y + 0.5) * scale - 0.5;
  c.pixel_image_width = even(c.pixel_image_width);
  c.pixel_image_height = even(c.pixel_image_height);
  return c;
}

AccuracyField field_named(const AccuracySuite& suite, const std::string& name, const std::string& path) {
  std::string known;
  for (const auto& [key, value] : suite.named_fields.items()) {
    if (key == name) {
      const std::string field_path = "/fields/" + key;
      auto field = params_from_json<AccuracyField>(value, field_path);
      CameraModel(field.calibration, field_path + "/calibration");
      for (const auto size : {field.calibration.pixel_image_width, field.calibration.pixel_image_height}) {
        if (size == 0) {
          throw SettingsError(field_path +
                              "/calibration: pixel_image_width and pixel_image_height are missing; they are "
                              "the size of the images");
        }
      }
      return field;
    }
    known += (known.empty() ? "" : ", ") + key;
  }
  throw SettingsError(fmt::format("{}: no field \"{}\"; known: {}", path, name, known));
}

Json merged(Json below, const Json& above) {
  below.merge_patch(above);
  return below;
}

void check_pixel_formats(const AccuracyCondition& condition, const std::string& path) {
  for (std::size_t i = 0; i < condition.pixel_formats.size(); ++i) {
    const auto format = pixel_format_named(condition.pixel_formats[i]);
    if (format && *format != PixelFormat::kMono8) continue;
    refuse(fmt::format("{}/pixel_formats/{}", path, i), condition.pixel_formats[i],
           "a pixel format with colours, such as \"uyvy\", \"rgb24\" or \"bayer_rg8\"");
  }
}

}  // namespace

Trial trial_of(const AccuracySuite& suite, std::size_t index, const std::string& pixel_format) {
  const AccuracyCondition& condition = suite.conditions[index];
  const std::string path = "/conditions/" + std::to_string(index);
  AccuracyField field = field_named(suite, condition.field, path + "/field");
  if (condition.px_per_mm) {
    field.calibration = scaled(field.calibration, *condition.px_per_mm / px_per_mm_of(field.calibration));
  }
  Trial out;
  out.px_per_mm = px_per_mm_of(field.calibration);
  out.frames = condition.frames.value_or(field.frames);
  out.limits = params_from_json<AccuracyLimits>(merged(suite.must, condition.must), path + "/must");
  const Json source =
      merged(merged(suite.source, condition.source), Json{{"width", field.calibration.pixel_image_width},
                                                          {"height", field.calibration.pixel_image_height},
                                                          {"pixel_format", pixel_format}});
  out.source = simulator_options(source, path + "/source");
  out.learn_source = simulator_options(merged(source, merged(suite.learn_source, condition.learn_source)),
                                       path + "/learn_source");
  out.halls = condition.halls.empty() ? suite.halls : condition.halls;
  out.colors = condition.colors.value_or(suite.colors);
  out.learn_frames = condition.learn_frames ? condition.learn_frames : suite.learn_frames;

  static_cast<FieldSize&>(out.config.field) = field.size;
  out.config.teams.yellow.robot_height = out.config.teams.blue.robot_height = condition.robot_height;
  read_params(out.config.teams, condition.teams, path + "/teams");
  CameraSettings& camera = out.config.cameras.emplace_back();
  camera.calibration = field.calibration;
  camera.stages =
      read_stages(stage_table(), merged(suite.stages, condition.stages), path + "/stages").complete;
  return out;
}

AccuracySuite read_accuracy_suite(const std::string& file) {
  const Json json = read_json_file(file);
  try {
    auto suite = params_from_json<AccuracySuite>(json, "");
    for (std::size_t i = 0; i < suite.conditions.size(); ++i) {
      const AccuracyCondition& condition = suite.conditions[i];
      const std::string path = "/conditions/" + std::to_string(i);
      if (condition.name.empty()) refuse(path + "/name", condition.name, "a name");
      check_pixel_formats(condition, path);
      for (const std::string& format : condition.pixel_formats) trial_of(suite, i, format);
    }
    return suite;
  } catch (const SettingsError& error) {
    throw SettingsError(file + ": " + error.what());
  }
}

}  // namespace sslv
