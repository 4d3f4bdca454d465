// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

/// Human-readable text for the answer of /api/network/packets, to which the answer of /api/network/listeners
/// was added as "listeners".
std::string packets_text(const Json& packets);

}  // namespace sslv
