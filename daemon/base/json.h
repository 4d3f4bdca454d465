// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

namespace sslv {

/// Keeps the order in which keys were written, so that a settings file reads back as it was laid out.
using Json = nlohmann::ordered_json;

}  // namespace sslv
