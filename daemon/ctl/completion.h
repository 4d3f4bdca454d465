// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <CLI/App.hpp>

namespace sslv {

/// Returns a script with which a shell ("bash", "zsh" or "fish") completes the commands and options of a
/// program, and file names where neither a command nor an option fits.
std::string completion_script(const CLI::App& app, const std::string& shell);

}  // namespace sslv
