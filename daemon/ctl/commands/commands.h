// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ctl/commands/command_line.h"

namespace sslv {

// Each function adds one command: its options, its help, and its action.

// State of a running daemon.
void add_status(CommandLine& line);
void add_watch(CommandLine& line);
void add_cameras(CommandLine& line);
void add_field(CommandLine& line);
void add_alerts(CommandLine& line);
void add_events(CommandLine& line);
void add_check(CommandLine& line);
void add_diagnostics(CommandLine& line);
void add_packets(CommandLine& line);
void add_log(CommandLine& line);
void add_support_bundle(CommandLine& line);

// Cameras of a running daemon.
void add_snapshot(CommandLine& line);
void add_controls(CommandLine& line);
void add_sources(CommandLine& line);

void add_colours(CommandLine& line);

// Settings of a running daemon.
void add_settings(CommandLine& line);
void add_backup(CommandLine& line);
void add_restore(CommandLine& line);
void add_field_presets(CommandLine& line, CLI::App* field);  // to the command `field`
void add_profiles(CommandLine& line);
void add_history(CommandLine& line);
void add_undo(CommandLine& line);

void add_calibrate(CommandLine& line);
void add_learn_colours(CommandLine& line);
void add_passwd(CommandLine& line);
void add_match_lock(CommandLine& line);

// What a running daemon records.
void add_match_log(CommandLine& line);
void add_clip(CommandLine& line);

}  // namespace sslv
