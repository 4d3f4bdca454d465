// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/aravis/aravis_library.h"
#include "capture/aravis/aravis_options.h"

#include <string>
#include <vector>

namespace sslv {

/// Sets an open camera up for streaming. `label` is how the admin calls it. Throws CaptureError naming
/// camera, option and value when it refuses one; what it can do without becomes a warning.
void set_up_aravis(ArvCamera* camera, const AravisOptions& options, const std::string& label,
                   std::vector<std::string>& warnings);

}  // namespace sslv
