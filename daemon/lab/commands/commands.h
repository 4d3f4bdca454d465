// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ctl/commands/command_line.h"

namespace sslv {

// Each function adds one command: its options, its help, and its action.

void add_process(CommandLine& line);
void add_bench(CommandLine& line);
void add_simulate(CommandLine& line);
void add_score(CommandLine& line);
void add_track(CommandLine& line);
void add_annotate(CommandLine& line);

void add_calibrate(CommandLine& line);
void add_learn_colours(CommandLine& line);
void add_replay(CommandLine& line);
void add_clip(CommandLine& line);
void add_match_log(CommandLine& line);

}  // namespace sslv
