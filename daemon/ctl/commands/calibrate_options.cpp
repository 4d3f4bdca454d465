// SPDX-License-Identifier: Apache-2.0
#include "ctl/commands/calibrate_options.h"

#include "ctl/commands/command_line.h"
#include "ctl/terminal_text.h"

#include <cstdlib>
#include <iostream>

namespace sslv {

void CalibrateOptions::add_to(CLI::App* command) {
  command->add_option("--points", words.points_file,
                      "file of points: [{\"x\": px, \"y\": px, \"name\": may be left out}, ...]");
  command->add_option("--frames", words.frames, "images to take the mean of; default: 10")
      ->check(CLI::Range(1, 100));
  command->add_option("--height", words.height_mm, "the camera's height above the floor in mm, if measured");
  command->add_option("--height-sigma", words.height_sigma_mm, "accuracy of that height in mm; default: 20");
  command->add_option("--focal", words.focal_px, "focal length in px, if known");
  command
      ->add_option("--plus-x", words.plus_x,
                   "side of the image where the +x half lies: right, left, up or down")
      ->check(CLI::IsMember({"right", "left", "up", "down"}));
  command
      ->add_option(
          "--lines", words.lines,
          "what the field's sizes were measured to: middle, as in the rules, or outer-edge; default: middle, "
          "unless outer-edge fits the image clearly better")
      ->check(CLI::IsMember({"outer-edge", "middle"}));
  command->add_option("--output", calibration_file,
                      "calibration to write, in the format of the settings; -: standard output");
  command->add_option("--report", report_file, "file for all figures");
  command->add_flag("--json", as_json, "print the report as JSON");
}

int CalibrateOptions::tell(const Json& report, std::string (*text)(const Json&)) const {
  const auto write = [](const std::string& file, const Json& json) {
    Output output(file);
    output.stream() << terminal_json(json) << "\n";
    output.finish();
  };
  if (!report_file.empty()) write(report_file, report);
  if (!calibration_file.empty() && report.at("found") == true)
    write(calibration_file, report.at("calibration"));
  // If a file is written to standard output, the text must not be.
  (calibration_file == "-" || report_file == "-" ? std::cerr : std::cout)
      << answer_text(report, as_json, text);
  return report.at("accepted") == true ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace sslv
