// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ctl/commands/command_line.h"

#include <initializer_list>

namespace sslv {

// Commands that need no service are in ssl-visionlab. They were once in ssl-visionctl, and scripts may still
// call them there: it replaces itself with the ssl-visionlab in the same folder, with the same arguments.

/// Adds such commands, hidden from the help, to the program or to one of its commands. Call it last: commands
/// added later would repeat the footer that names ssl-visionlab.
void add_laboratory_commands(CommandLine& line, CLI::App* parent, std::initializer_list<const char*> names);
/// Adds --input, which hands over to the command of the same name in ssl-visionlab.
void add_laboratory_input(CommandLine& line, CLI::App* command);

}  // namespace sslv
