// SPDX-License-Identifier: Apache-2.0
// ssl-visionctl: queries and controls a running daemon. Links no engine: commands that need no daemon are in
// ssl-visionlab.
#include "ctl/commands/commands.h"
#include "ctl/commands/laboratory.h"

namespace {

using namespace sslv;

void add_commands(CommandLine& line) {
  add_status(line);
  add_watch(line);
  add_cameras(line);
  add_alerts(line);
  add_events(line);
  add_check(line);
  add_diagnostics(line);
  add_packets(line);
  add_log(line);
  add_support_bundle(line);
  add_snapshot(line);
  add_controls(line);
  add_sources(line);
  add_colours(line);
  add_settings(line);
  add_backup(line);
  add_restore(line);
  add_field(line);
  add_profiles(line);
  add_history(line);
  add_undo(line);
  add_clip(line);
  add_calibrate(line);
  add_learn_colours(line);
  add_passwd(line);
  add_match_lock(line);
  add_match_log(line);
  add_completion(line);
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine line("ssl-visionctl", "Queries and controls a running ssl-visiond.");
  add_commands(line);
  add_laboratory_commands(line, &line.app,
                          {"annotate", "bench", "process", "replay", "score", "simulate", "track"});
  line.app.footer("Without a service: ssl-visionlab --help");
  return line.run(argc, argv);
}
