// SPDX-License-Identifier: Apache-2.0
#include "ctl/terminal_text.h"
#include "lab/commands/commands.h"
#include "lab/commands/offline_options.h"
#include "lab/learn.h"
#include "lab/learnt_colors_json.h"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

namespace sslv {

void add_learn_colours(CommandLine& line) {
  struct Options {
    CameraChoice choice;
    RawFormat raw;
    LearnInput input;
    std::string lut_file;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand("learn-colours", "learn a camera's colour table automatically");
  command->add_option("--settings", o->choice.settings_file, "settings file")->required();
  command->add_option("--camera", o->choice.camera_id, "id of the camera in it")->capture_default_str();
  command
      ->add_option("--input", o->input.path, "image, raw frame, video, or a folder of images or raw frames")
      ->required();
  o->raw.add_to(command);
  command->add_option("--frames", o->input.frames, "images to learn from")
      ->check(CLI::Range(1, 10))
      ->capture_default_str();
  command->add_option("--every", o->input.every, "use every Nth image, so that things have moved in between")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--output", o->lut_file, "table to write (.lut); -: standard output");
  command->add_flag("--json", o->as_json, "print the result as JSON");
  line.on(command, [o] {
    o->raw.parse();
    o->input.pixel_format = o->raw.pixel_format;
    o->input.width = o->raw.width;
    o->input.height = o->raw.height;
    const Config config = o->choice.config();
    const LearntColors learnt = learn_from_recording(config, o->choice.index_in(config), o->input, std::cerr);
    const LabelSet labels(config.own_labels, "/own_labels");
    const Json report = learnt_colors_json(learnt, labels);
    if (!o->lut_file.empty() && learnt.lut) {
      const auto bytes = lut_file_bytes(*learnt.lut, labels);
      Output output(o->lut_file);
      output.stream().write(reinterpret_cast<const char*>(bytes.data()),
                            static_cast<std::streamsize>(bytes.size()));
      output.finish();
    }
    (o->lut_file == "-" ? std::cerr : std::cout) << answer_text(report, o->as_json, learnt_colors_text);
    return learnt.problem.empty() ? EXIT_SUCCESS : EXIT_FAILURE;
  });
}

}  // namespace sslv
