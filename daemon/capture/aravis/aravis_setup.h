// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/aravis/aravis_library.h"
#include "capture/aravis/aravis_options.h"

#include <string>
#include <vector>

namespace sslv {

/// Configures an open camera for streaming. `label` is the admin's name for the camera. Throws CaptureError
/// naming camera, option and value if the camera refuses a value; the refusal of an optional feature becomes
/// a warning.
void set_up_aravis(ArvCamera* camera, const AravisOptions& options, const std::string& label,
                   std::vector<std::string>& warnings);

}  // namespace sslv
