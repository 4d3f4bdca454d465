// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/simulator/simulator_options.h"
#include "capture/source.h"

#include <string>

namespace sslv {

/// Parses the options over their defaults and validates their combination. Throws SettingsError, beginning
/// with `path`.
SimulatorOptions simulator_options(const Json& options, const std::string& path);

/// "simulator": a camera over a field with moving robots and balls, drawn with the camera's own calibration.
/// Images are exposed at whole multiples of the frame period in Unix time, so all simulated cameras expose
/// simultaneously. Each image is drawn in advance and delivered at that moment, so latency measured from
/// t_capture_s is the pipeline's alone. A few images are queued if they are taken late, as in a camera
/// driver's buffers; older images count as dropped. With frame_rate_hz 0 there is no waiting, and the latency
/// includes drawing. Images are skipped while all buffers are held.
Backend simulator_backend();

}  // namespace sslv
