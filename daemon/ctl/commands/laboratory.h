// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ctl/commands/command_line.h"

#include <initializer_list>

namespace sslv {

// What needs no service is in ssl-visionlab. Scripts may still call it as a part of ssl-visionctl, which it
// once was: ssl-visionctl becomes the ssl-visionlab in the same folder, with the same words.

/// Adds such commands, hidden, to the program or to one of its commands.
void add_laboratory_commands(CommandLine& line, CLI::App* parent, std::initializer_list<const char*> names);
/// Adds --input, with which the command of the same name in ssl-visionlab takes over.
void add_laboratory_input(CommandLine& line, CLI::App* command);

}  // namespace sslv
