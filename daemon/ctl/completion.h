// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <CLI/App.hpp>

namespace sslv {

/// A script with which a shell ("bash", "zsh" or "fish") completes the commands and options of a command
/// line; file names where neither fits.
std::string completion_script(const CLI::App& app, const std::string& program, const std::string& shell);

}  // namespace sslv
