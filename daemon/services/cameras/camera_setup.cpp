// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_setup.h"

#include "base/params_json.h"

#include <algorithm>
#include <utility>

namespace sslv {
namespace {

template <class P>
bool same(const P& a, const P& b) {
  return params_to_json(a) == params_to_json(b);
}

bool same(const std::optional<CameraCalibration>& a, const std::optional<CameraCalibration>& b) {
  return a.has_value() == b.has_value() && (!a || same(*a, *b));
}

bool same_labels(const Config& a, const Config& b) {
  return std::equal(a.own_labels.begin(), a.own_labels.end(), b.own_labels.begin(), b.own_labels.end(),
                    [](const OwnLabel& one, const OwnLabel& other) { return same(one, other); });
}

bool same_setup(const Config& config, const CameraSettings& camera, const CameraInUse& previous) {
  return camera.stack == previous.settings.stack && camera.stages == previous.settings.stages &&
         same(camera.calibration, previous.settings.calibration) &&
         same(camera.colors, previous.settings.colors) && same(camera.mask, previous.settings.mask) &&
         same<FieldSize>(config.field, previous.config.field) && same(config.teams, previous.config.teams) &&
         config.patterns_file == previous.config.patterns_file && same_labels(config, previous.config);
}

}  // namespace

std::optional<NewSetup> plan_setup(const Config& config, std::size_t i,
                                   const std::optional<CameraInUse>& previous, const LoadTable& load_table) {
  const CameraSettings& camera = config.cameras[i];
  if (previous && same_setup(config, camera, *previous)) return std::nullopt;
  NewSetup out;
  CameraSetup& setup = out.setup;
  if (previous && previous->settings.running.stages == camera.running.stages) {
    setup.pipeline = previous->setup.pipeline;
    setup.parameters = setup.pipeline->parameters_of(camera.stage_params);
  }
  out.keeps_colors =
      previous && same(previous->settings.colors, camera.colors) && same_labels(config, previous->config);
  setup.context =
      make_context(config, i, out.keeps_colors ? previous->setup.context.accepted_lut : nullptr, load_table);
  return out;
}

void NewSetup::make_stages(const CameraSettings& camera) {
  if (setup.pipeline) return;
  // The stack was validated when it was read.
  setup.pipeline = std::make_shared<Pipeline>(stage_table(), camera.running.stages, "/cameras");
  setup.parameters = setup.pipeline->parameters_of(camera.stage_params);
}

CameraSetup with_robot_heights(CameraSetup setup, const std::array<double, 2>& robot_height_mm) {
  Scene scene = *setup.context.scene;
  scene.robot_height_mm = robot_height_mm;
  setup.context.scene = std::make_shared<const Scene>(std::move(scene));
  return setup;
}

}  // namespace sslv
