// SPDX-License-Identifier: Apache-2.0
// ssl-visionlab: works on files without a daemon: calibrates, learns colours and replays; simulates frames
// with truth, and measures the accuracy and speed of stacks.
#include "config/stages.h"
#include "kit/sandbox/stage_process.h"
#include "lab/commands/commands.h"

int main(int argc, char** argv) {
  using namespace sslv;
  if (const auto code = stage_process_main(argc, argv)) return *code;
  const EndOfStageProcesses end;
  CommandLine line("ssl-visionlab", "Works on the files of ssl-visiond without a service.");
  add_process(line);
  add_bench(line);
  add_simulate(line);
  add_score(line);
  add_track(line);
  add_annotate(line);
  add_calibrate(line);
  add_learn_colours(line);
  add_replay(line);
  add_clip(line);
  add_match_log(line);
  add_completion(line);
  return line.run(argc, argv);
}
