// SPDX-License-Identifier: Apache-2.0
#pragma once

// JSON of a camera as in docs/openapi.json, and metrics for Prometheus.

#include "base/json.h"
#include "health/exposure.h"
#include "health/metrics_text.h"
#include "services/cameras/running_camera.h"
#include "vision/field_view.h"

#include <memory>
#include <optional>
#include <vector>

namespace sslv {

/// CameraStatus.
Json camera_json(const RunningCamera& camera, const CameraHealth& health, const std::optional<Hang>& hang);
Json camera_json(const RunningCamera& camera);
/// CameraDiagnostics.
Json camera_diagnostics_json(const RunningCamera& camera, const std::optional<Exposure>& exposure);
/// Control. `saved`: name -> value.
Json control_json(const Control& control, const Json& saved, const std::vector<UnsavedControl>& unsaved);
/// {"hidden": [[left, top, width, height], ...]}; `view`: null if nothing is hidden.
Json field_view_json(const FieldView* view);

void write_camera_metrics(MetricsText& out, const std::vector<std::shared_ptr<RunningCamera>>& cameras);

}  // namespace sslv
