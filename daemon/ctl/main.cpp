// SPDX-License-Identifier: Apache-2.0
// ssl-visionctl: asks a running daemon, or runs the pipeline over files without one.
#include "base/error.h"
#include "base/plain_text.h"
#include "config/stages.h"
#include "config/version.h"
#include "ctl/commands/commands.h"
#include "kit/sandbox/stage_process.h"

#include <cstdlib>
#include <iostream>

#include <sysexits.h>

namespace {

using namespace sslv;

void add_commands(CommandLine& line) {
  line.app.set_version_flag("--version", std::string("ssl-visionctl ") + kVersion);
  line.app.require_subcommand(1);
  line.app.add_option("--daemon", line.daemon, "address of the daemon's panel")->capture_default_str();
  line.app.add_option(
      "--password-file", line.password_file,
      "file with the daemon's password in its first line; else SSL_VISIOND_PASSWORD, else it is asked for");

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
  add_process(line);
  add_bench(line);
  add_simulate(line);
  add_score(line);
  add_track(line);
  add_annotate(line);
  add_replay(line);
  add_clip(line);
  add_calibrate(line);
  add_learn_colours(line);
  add_passwd(line);
  add_match_lock(line);
  add_match_log(line);
  add_completion(line);
}

int run(int argc, char** argv) {
  CommandLine line;
  add_commands(line);
  try {
    line.app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return line.app.exit(error) == 0 ? EXIT_SUCCESS : EX_USAGE;
  }
  return line.act();
}

}  // namespace

int main(int argc, char** argv) {
  if (const auto code = stage_process_main(argc, argv)) return *code;
  const EndOfStageProcesses end;
  try {
    return run(argc, argv);
  } catch (const SettingsError& error) {
    std::cerr << "ssl-visionctl: " << escaped_lines(error.what()) << "\n";
    return EX_CONFIG;
  } catch (const std::exception& error) {
    std::cerr << "ssl-visionctl: " << escaped_lines(error.what()) << "\n";
    return EXIT_FAILURE;
  }
}
