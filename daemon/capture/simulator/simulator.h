// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_options.h"
#include "capture/source.h"

#include <string>

namespace sslv {

/// Options read over their defaults and checked together. Throws SettingsError, beginning with `path`.
SimulatorOptions simulator_options(const Json& options, const std::string& path);

/// The row "simulator": a camera over a field with moving robots and balls, drawn with the camera's own
/// calibration. Images are exposed at whole multiples of the frame period in Unix time, so all simulated
/// cameras expose at once. Each is drawn ahead and handed over at that moment: latency measured from
/// t_capture_s is the pipeline's alone. A few images wait when they are taken late, as in the buffers of a
/// camera's driver; older ones count as dropped. With frame_rate_hz 0 there is no waiting, and drawing
/// counts. When all its buffers are held by others, images are left out.
Backend simulator_backend();

}  // namespace sslv
