// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/log_ring.h"

#include <string_view>
#include <utility>

#include <fmt/core.h>

/// Writes one line per message to standard error with time and level, or to the journal if standard error is
/// connected to it. Journal entries have PRIORITY, CAMERA if the line begins with "camera 3", and
/// MESSAGE_ID=kAuditId if it begins with "audit". The newest lines are kept for the panel.
namespace sslv::log {

/// MESSAGE_ID of the lines that say who requested a change.
inline constexpr const char* kAuditId = "5f2f9a6ec1b74d1c9b0e8f4b6f0f6a1d";

/// Messages below this level are not written. Default: info.
void set_level(Level level);

void write(Level level, std::string_view message);

/// The newest lines, from any thread.
const LogRing& recent();

template <class... Args>
void debug(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kDebug, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void info(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kInfo, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void warning(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kWarning, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void error(fmt::format_string<Args...> format, Args&&... args) {
  write(Level::kError, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace sslv::log
