// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

namespace sslv {

/// Whether the field that calibration rests on (sizes and lines, not the goals' height or ball and robot) is
/// another one than at a Unix time. `steps` are the settings' history, newest first, as far as it is known:
/// what was changed before, or in the admin's own file, is not seen.
bool field_changed_since(double time_s, const Json& settings, const Json& steps);

}  // namespace sslv
