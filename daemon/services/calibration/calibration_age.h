// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

namespace sslv {

/// Whether the painted field (sizes and lines, not the goals' height, the ball or the robots) differs from
/// the painted field at Unix time `time_s`. `steps`: the settings' history, newest first. Changes before its
/// oldest step, or in the admin's own file, are not detected.
bool field_changed_since(double time_s, const Json& settings, const Json& steps);

}  // namespace sslv
