// SPDX-License-Identifier: Apache-2.0
#include "ctl/colors.h"
#include "ctl/commands/commands.h"
#include "ctl/commands/offline_options.h"
#include "ctl/learn.h"
#include "ctl/learnt_colors_json.h"
#include "ctl/terminal_text.h"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

#include <fmt/format.h>

namespace sslv {
namespace {

struct LearnOptions {
  CameraChoice choice;
  RawFormat raw;
  LearnInput input;
  std::string lut_file;
  bool as_json = false, accept = false;
};

/// Learns from the running daemon's live images.
int learn_live(const LearnOptions& o, const Client& daemon) {
  const Json report = learn_running(daemon, o.choice.camera_id, o.input.frames);
  print_answer(report, o.as_json, learning_text);
  if (report.at("learnt") != true) return EXIT_FAILURE;
  if (o.accept) {
    daemon.post(fmt::format("/api/cameras/{}/colors/learning/accept", o.choice.camera_id), Json::object());
    std::cerr << "It is in use.\n";
  }
  return EXIT_SUCCESS;
}

int learn(LearnOptions& o) {
  o.raw.parse();
  o.input.pixel_format = o.raw.pixel_format;
  o.input.width = o.raw.width;
  o.input.height = o.raw.height;
  const Config config = o.choice.config();
  const LearntColors learnt = learn_from_recording(config, o.choice.index_in(config), o.input, std::cerr);
  const LabelSet labels(config.own_labels, "/own_labels");
  const Json report = learnt_colors_json(learnt, labels);
  if (!o.lut_file.empty() && learnt.lut) {
    const auto bytes = lut_file_bytes(*learnt.lut, labels);
    Output output(o.lut_file);
    output.stream().write(reinterpret_cast<const char*>(bytes.data()),
                          static_cast<std::streamsize>(bytes.size()));
    output.finish();
  }
  (o.lut_file == "-" ? std::cerr : std::cout) << answer_text(report, o.as_json, learnt_colors_text);
  return learnt.problem.empty() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

void add_learn_colours(CommandLine& line) {
  const auto o = std::make_shared<LearnOptions>();
  CLI::App* command =
      line.app.add_subcommand("learn-colours",
                              "learn a camera's colour table automatically, from the daemon's "
                              "images or from files");
  command->add_option("--camera", o->choice.camera_id, "id of the camera")->capture_default_str();
  CLI::Option* input = command->add_option("--input", o->input.path,
                                           "image, raw frame, video, or a folder of images or raw frames; "
                                           "default: the daemon's camera");
  CLI::Option* settings =
      command->add_option("--settings", o->choice.settings_file, "settings file with that camera")
          ->needs(input);
  input->needs(settings);
  o->raw.add_to(command);
  command->add_option("--frames", o->input.frames, "images to learn from")
      ->check(CLI::Range(1, 10))
      ->capture_default_str();
  command->add_option("--every", o->input.every, "use every Nth image, so that things have moved in between")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str()
      ->needs(input);
  command->add_option("--output", o->lut_file, "table to write (.lut); -: standard output")->needs(input);
  command->add_flag("--accept", o->accept, "apply it")->excludes(input);
  command->add_flag("--json", o->as_json, "print the result as JSON");
  line.on(command, [&line, o, input] { return input->empty() ? learn_live(*o, line.client()) : learn(*o); });
}

}  // namespace sslv
