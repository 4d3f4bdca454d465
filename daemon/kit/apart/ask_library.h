// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <chrono>
#include <stop_token>
#include <string>

namespace sslv::apart {

/// Asks a library something, in a process that lives for this question alone: {"ask": "describe"}, or
/// {"ask": "parse", "floor", "stage", "json", "path"}. For threads that may wait. Throws std::runtime_error:
/// what the library refuses, or how its process ended; soon when it is told to stop.
Json ask_library(const std::string& library, const Json& question, const std::stop_token& stop,
                 std::chrono::milliseconds within);

}  // namespace sslv::apart
