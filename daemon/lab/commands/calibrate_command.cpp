// SPDX-License-Identifier: Apache-2.0
#include "ctl/commands/calibrate_options.h"
#include "lab/calibrate.h"
#include "lab/commands/commands.h"
#include "lab/commands/offline_options.h"

#include <iostream>
#include <memory>
#include <optional>
#include <string>

namespace sslv {

void add_calibrate(CommandLine& line) {
  struct Options {
    CalibrateOptions common;
    RawFormat raw;
    std::string input, field, previous_file;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand("calibrate", "find where a camera hangs, from its images");
  command->add_option("--input", o->input, "image, raw frame, video, or a folder; their mean is taken")
      ->required();
  o->raw.add_to(command);
  command->add_option("--field", o->field, "division-a, division-b, or a settings file with this field")
      ->required();
  o->common.add_to(command);
  command->get_option("--output")->required();
  command->add_option("--previous", o->previous_file, "calibration to compare with");
  line.on(command, [o] {
    o->raw.parse();
    const CalibrationRequest request = checked_request(o->common.words);
    const FieldSize field = field_named(o->field);
    std::optional<CameraCalibration> previous;
    if (!o->previous_file.empty()) previous = read_calibration(o->previous_file);
    const CalibrationReport report = calibrate_recording(
        {o->input, o->raw.pixel_format, o->raw.width, o->raw.height}, request, field, previous, std::cerr);
    return o->common.tell(report_json(report), calibration_text);
  });
}

}  // namespace sslv
