// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/log_ring.h"

#include <string_view>
#include <utility>

#include <fmt/core.h>

/// One line a message, to standard error with time and level; the newest are kept for the panel.
namespace sslv::log {

/// Messages below this level are not written. Default: info.
void set_level(Level level);

void write(Level level, std::string_view message);

/// The newest lines.
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
