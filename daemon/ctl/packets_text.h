// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <string>

namespace sslv {

/// The answer of /api/network/packets, with that of /api/network/listeners as its "listeners", for people.
std::string packets_text(const Json& packets);

}  // namespace sslv
