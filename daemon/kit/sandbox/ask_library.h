// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"

#include <chrono>
#include <stop_token>
#include <string>

namespace sslv::sandbox {

/// Asks a library one question in a process started for it: {"ask": "describe"}, or {"ask": "parse", "floor",
/// "stage", "json", "path"}. Returns the answer, an object. May block; returns soon after `stop` is
/// requested. Throws std::runtime_error with the library's error or the reason why its process ended.
Json ask_library(const std::string& library, const Json& question, const std::stop_token& stop,
                 std::chrono::milliseconds within);

}  // namespace sslv::sandbox
