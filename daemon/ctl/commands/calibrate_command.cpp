// SPDX-License-Identifier: Apache-2.0
#include "calibration/calibration_json.h"
#include "ctl/calibrate.h"
#include "ctl/commands/commands.h"
#include "ctl/commands/offline_options.h"
#include "ctl/terminal_text.h"

#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

struct CalibrateOptions {
  CalibrateWords words;
  RawFormat raw;
  std::string input, field, previous_file, calibration_file, report_file;
  int camera_id = 0;
  std::vector<int> together_ids;
  double together_s = 10;
  bool together = false, accept = false, force = false, as_json = false;
};

/// Writes the result of a calibration: the calibration, if found, to `calibration_file`, the whole report to
/// the report file, and human-readable text to the terminal. Returns the exit code.
int tell(const CalibrateOptions& o, const Json& report, const std::string& calibration_file,
         std::string (*text)(const Json&)) {
  const auto write = [](const std::string& file, const Json& json) {
    Output output(file);
    output.stream() << json_text(json) << "\n";
    output.finish();
  };
  if (!o.report_file.empty()) write(o.report_file, report);
  if (!calibration_file.empty() && report.at("found") == true)
    write(calibration_file, report.at("calibration"));
  // If a file is written to standard output, the text must not be.
  (calibration_file == "-" || o.report_file == "-" ? std::cerr : std::cout)
      << answer_text(report, o.as_json, text);
  return report.at("accepted") == true ? EXIT_SUCCESS : EXIT_FAILURE;
}

int calibrate_several_cameras(const CalibrateOptions& o, const Client& client) {
  const Json report = calibrate_together(client, {{"cameras", o.together_ids},
                                                  {"frames", o.words.frames.value_or(10)},
                                                  {"seconds", o.together_s},
                                                  {"force", o.force}});
  const int exit_code = tell(o, report, "", joint_calibration_text);
  if (o.accept && exit_code == EXIT_SUCCESS) {
    client.post("/api/calibration/accept", {{"force", o.force}});
    std::cerr << "They are in use.\n";
  }
  return exit_code;
}

int calibrate_camera(const CalibrateOptions& o, const Client& client) {
  Json asked = calibration_request(o.words);
  asked["force"] = o.force;
  const Json report = calibrate_running(client, o.camera_id, asked);
  const int exit_code = tell(o, report, o.calibration_file, calibration_text);
  if (o.accept && exit_code == EXIT_SUCCESS) {
    client.post(fmt::format("/api/cameras/{}/calibration/accept", o.camera_id), {{"force", o.force}});
    std::cerr << "It is in use.\n";
  }
  return exit_code;
}

int calibrate_files(CalibrateOptions& o) {
  const Json asked = calibration_request(o.words);
  o.raw.parse();
  const CalibrationRequest request = read_calibration_request(asked);
  const FieldSize field = field_named(o.field);
  std::optional<CameraCalibration> previous;
  if (!o.previous_file.empty()) previous = read_calibration(o.previous_file);
  const CalibrationReport report = calibrate_recording(
      {o.input, o.raw.pixel_format, o.raw.width, o.raw.height}, request, field, previous, std::cerr);
  return tell(o, report_json(report), o.calibration_file, calibration_text);
}

}  // namespace

void add_calibrate(CommandLine& line) {
  const auto o = std::make_shared<CalibrateOptions>();
  CLI::App* command = line.app.add_subcommand(
      "calibrate", "find where a camera hangs, from an image of the daemon's camera or from files");
  CLI::Option* of_daemon = command->add_option("--camera", o->camera_id, "id of the daemon's camera");
  CLI::Option* of_files =
      command->add_option("--input", o->input, "image, raw frame, video, or a folder; their mean is taken");
  of_files->excludes(of_daemon);
  CLI::Option* of_several =
      command
          ->add_flag("--together", o->together,
                     "refine several calibrated cameras of the daemon, so that they agree where they overlap")
          ->excludes(of_daemon)
          ->excludes(of_files);
  command
      ->add_option("--cameras", o->together_ids,
                   "ids of these cameras, such as 0,1; default: all calibrated cameras")
      ->delimiter(',')
      ->needs(of_several);
  command->add_option("--seconds", o->together_s, "how long to look for robots that two of them see")
      ->check(CLI::Range(0.0, 600.0))
      ->capture_default_str()
      ->needs(of_several);
  o->raw.add_to(command);
  CLI::Option* field =
      command->add_option("--field", o->field, "division-a, division-b, or a settings file with this field")
          ->needs(of_files);
  command->add_option("--points", o->words.points_file,
                      "file of points: [{\"x\": px, \"y\": px, \"name\": may be left out}, ...]");
  command->add_option("--frames", o->words.frames, "images to take the mean of; default: 10")
      ->check(CLI::Range(1, 100));
  command->add_option("--height", o->words.height_mm,
                      "the camera's height above the floor in mm, if measured");
  command->add_option("--height-sigma", o->words.height_sigma_mm,
                      "accuracy of that height in mm; default: 20");
  command->add_option("--focal", o->words.focal_px, "focal length in px, if known");
  command
      ->add_option("--plus-x", o->words.plus_x,
                   "side of the image where the +x half lies: right, left, up or down")
      ->check(CLI::IsMember({"right", "left", "up", "down"}));
  command
      ->add_option(
          "--lines", o->words.lines,
          "what the field's sizes were measured to: middle, as in the rules, or outer-edge; default: middle, "
          "unless outer-edge fits the image clearly better")
      ->check(CLI::IsMember({"outer-edge", "middle"}));
  command->add_option("--previous", o->previous_file, "calibration to compare with")->needs(of_files);
  CLI::Option* output =
      command->add_option("--output", o->calibration_file,
                          "calibration to write, in the format of the settings; -: standard output");
  command->add_option("--report", o->report_file, "file for all figures");
  command->add_flag("--json", o->as_json, "print the report as JSON");
  command->add_flag("--accept", o->accept, "apply it when it is good enough")->excludes(of_files);
  command->add_flag("--force", o->force, "even while the game is running")->excludes(of_files);
  for (const char* of_one_camera :
       {"--points", "--height", "--height-sigma", "--focal", "--plus-x", "--lines", "--output"})
    of_several->excludes(command->get_option(of_one_camera));
  command->callback([&line, o, of_daemon, of_files, field, output] {
    if (of_daemon->empty() && !o->together && (of_files->empty() || field->empty() || output->empty())) {
      throw CLI::ValidationError("calibrate",
                                 "needs --camera, or --together, or --input, --field and --output");
    }
    const bool running = !of_daemon->empty();
    line.act = [&line, o, running] {
      if (o->together) return calibrate_several_cameras(*o, line.client());
      return running ? calibrate_camera(*o, line.client()) : calibrate_files(*o);
    };
  });
}

}  // namespace sslv
