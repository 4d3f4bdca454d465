// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

/// Recordings of docs/openapi.json, for a terminal.
std::string recordings_text(const Json& recordings);
/// Clips of docs/openapi.json, for a terminal.
std::string clips_text(const Json& clips);

/// "1:02:03", or "2:03".
std::string clock_text(double seconds);
/// "1.5 MB".
std::string size_text(double bytes);

}  // namespace sslv
