// SPDX-License-Identifier: Apache-2.0
#include "ctl/colors.h"
#include "ctl/commands/commands.h"
#include "ctl/commands/laboratory.h"

#include <cstdlib>
#include <iostream>
#include <memory>

#include <fmt/format.h>

namespace sslv {

void add_learn_colours(CommandLine& line) {
  struct Options {
    int camera_id = 0, frames = 3;
    bool as_json = false, accept = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand(
      "learn-colours", "learn a camera's colour table automatically, from the service's live images");
  add_laboratory_input(line, command);
  command->add_option("--camera", o->camera_id, "id of the camera")->capture_default_str();
  command->add_option("--frames", o->frames, "images to learn from")
      ->check(CLI::Range(1, 10))
      ->capture_default_str();
  command->add_flag("--accept", o->accept, "apply it");
  command->add_flag("--json", o->as_json, "print the result as JSON");
  line.on(command, [&line, o] {
    const Client daemon = line.client();
    const Json report = learn_running(daemon, o->camera_id, o->frames);
    print_answer(report, o->as_json, learning_text);
    if (report.at("learnt") != true) return EXIT_FAILURE;
    if (o->accept) {
      daemon.post(fmt::format("/api/cameras/{}/colors/learning/accept", o->camera_id), Json::object());
      std::cerr << "It is in use.\n";
    }
    return EXIT_SUCCESS;
  });
}

}  // namespace sslv
