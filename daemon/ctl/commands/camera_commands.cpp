// SPDX-License-Identifier: Apache-2.0
#include "config/found_cameras_text.h"
#include "ctl/commands/commands.h"
#include "ctl/controls.h"

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace sslv {

void add_snapshot(CommandLine& line) {
  struct Options {
    int camera_id = 0;
    std::string file;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand("snapshot", "save the newest image of a camera as a JPEG file");
  command->add_option("--camera", o->camera_id, "id of the camera")->capture_default_str();
  command->add_option("--output", o->file, "file to write; -: standard output")->required();
  line.on(command, [&line, o] {
    const std::string jpeg = line.client().get(fmt::format("/api/cameras/{}/snapshot.jpg", o->camera_id));
    write_bytes(o->file, jpeg);
    return EXIT_SUCCESS;
  });
}

void add_controls(CommandLine& line) {
  struct Options {
    int camera_id = 0;
    bool for_now = false, as_json = false;
    std::vector<std::string> assignments;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand(
      "controls", "show a camera's own controls; NAME=VALUE sets a control, NAME runs an action");
  command->add_option("assignments", o->assignments, "NAME=VALUE, or the NAME of an action");
  command->add_option("--camera", o->camera_id, "id of the camera")->capture_default_str();
  command->add_flag("--for-now", o->for_now, "do not save it in the settings");
  add_json_flag(command, o->as_json);
  line.on(command, [&line, o] {
    const Client client = line.client();
    Json shown = Json::array();
    for (const std::string& one : o->assignments)
      shown.push_back(set_control(client, o->camera_id, one, !o->for_now));
    if (o->assignments.empty())
      shown = client.get_json(fmt::format("/api/cameras/{}/controls", o->camera_id)).at("controls");
    print_answer(shown, o->as_json, controls_text);
    return EXIT_SUCCESS;
  });
}

void add_sources(CommandLine& line) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* command =
      line.app.add_subcommand("sources", "list the cameras that the service could open, with their settings");
  add_json_flag(command, *as_json);
  line.on(command, [&line, as_json] {
    print_answer(line.client().get_json("/api/sources").at("sources"), *as_json, found_cameras_text);
    return EXIT_SUCCESS;
  });
}

}  // namespace sslv
