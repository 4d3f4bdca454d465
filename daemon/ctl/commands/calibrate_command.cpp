// SPDX-License-Identifier: Apache-2.0
#include "ctl/calibrate.h"
#include "ctl/commands/calibrate_options.h"
#include "ctl/commands/commands.h"
#include "ctl/commands/laboratory.h"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr const char* kNotApplied = "Not applied: --accept applies it.\n";
constexpr const char* kNotGood = "Not applied: --accept --force applies it anyway.\n";

struct ServiceOptions {
  CalibrateOptions common;
  int camera_id = 0;
  std::vector<int> together_ids;
  double together_s = 10;
  bool together = false, accept = false, force = false;
};

/// Whether to apply a result that is not good enough.
bool is_forced(const ServiceOptions& o, const Json& report) {
  if (report.at("found") != true) return false;
  if (!(o.accept && o.force)) std::cerr << kNotGood;
  return o.accept && o.force;
}

int calibrate_several_cameras(const ServiceOptions& o, const Client& client) {
  const Json report = calibrate_together(client, {{"cameras", o.together_ids},
                                                  {"frames", o.common.words.frames.value_or(10)},
                                                  {"seconds", o.together_s},
                                                  {"force", o.force}});
  const int exit_code = o.common.tell(report, joint_calibration_text);
  if (exit_code != EXIT_SUCCESS && !is_forced(o, report)) return exit_code;
  if (o.accept) client.post("/api/calibration/accept", {{"force", o.force}});
  std::cerr << (o.accept ? "They are in use.\n" : kNotApplied);
  return EXIT_SUCCESS;
}

int calibrate_camera(const ServiceOptions& o, const Client& client) {
  Json asked = calibration_request(o.common.words);
  asked["force"] = o.force;
  const Json report = calibrate_running(client, o.camera_id, asked);
  const int exit_code = o.common.tell(report, calibration_text);
  if (exit_code != EXIT_SUCCESS && !is_forced(o, report)) return exit_code;
  if (o.accept)
    client.post(fmt::format("/api/cameras/{}/calibration/accept", o.camera_id), {{"force", o.force}});
  std::cerr << (o.accept ? "It is in use.\n" : kNotApplied);
  return EXIT_SUCCESS;
}

}  // namespace

void add_calibrate(CommandLine& line) {
  const auto o = std::make_shared<ServiceOptions>();
  CLI::App* command = line.app.add_subcommand(
      "calibrate", "find where a camera hangs, from an image of the service's camera");
  add_laboratory_input(line, command);
  CLI::Option* of_one = command->add_option("--camera", o->camera_id, "id of the camera");
  CLI::Option* of_several =
      command
          ->add_flag("--together", o->together,
                     "refine several calibrated cameras, so that they agree where they overlap")
          ->excludes(of_one);
  command
      ->add_option("--cameras", o->together_ids,
                   "ids of these cameras, such as 0,1; default: all calibrated cameras")
      ->delimiter(',')
      ->needs(of_several);
  command->add_option("--seconds", o->together_s, "how long to look for robots that two of them see")
      ->check(CLI::Range(0.0, 600.0))
      ->capture_default_str()
      ->needs(of_several);
  o->common.add_to(command);
  command->add_flag("--accept", o->accept, "apply it when it is good enough");
  command->add_flag("--force", o->force, "even if it is not good enough, or while the game is running");
  for (const char* of_one_camera :
       {"--points", "--height", "--height-sigma", "--focal", "--plus-x", "--lines", "--output"})
    of_several->excludes(command->get_option(of_one_camera));
  command->callback([&line, o, of_one] {
    if (of_one->empty() && !o->together)
      throw CLI::ValidationError("calibrate", "needs --camera, --together or --input");
    line.act = [&line, o] {
      return o->together ? calibrate_several_cameras(*o, line.client()) : calibrate_camera(*o, line.client());
    };
  });
}

}  // namespace sslv
