// SPDX-License-Identifier: Apache-2.0
// ssl-visionctl: asks a running daemon, or runs the pipeline over files without one.
#include "calibration_json.h"
#include "cameras.h"
#include "capture/source.h"
#include "ctl/accuracy.h"
#include "ctl/bench.h"
#include "ctl/calibrate.h"
#include "ctl/client.h"
#include "ctl/controls.h"
#include "ctl/history.h"
#include "ctl/process.h"
#include "ctl/score.h"
#include "ctl/simulate.h"
#include "settings/store.h"
#include "version.h"

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <thread>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <sysexits.h>

namespace {

using namespace sslv;

/// The camera that the offline tools work with.
struct CameraChoice {
  std::string settings_file;
  int camera_id = 0;

  void add_to(CLI::App& command) {
    command.add_option("--settings", settings_file, "settings file")->required();
    command.add_option("--camera", camera_id, "id of the camera in it")->capture_default_str();
  }
  Config config() const {
    try {
      return read_config(read_json_file(settings_file));
    } catch (const SettingsError& error) {
      const std::string what = error.what();
      throw SettingsError(what.starts_with(settings_file) ? what : settings_file + ": " + what);
    }
  }
  std::size_t index_in(const Config& config) const {
    std::string known;
    for (std::size_t i = 0; i < config.cameras.size(); ++i) {
      if (config.cameras[i].id == camera_id) return i;
      known += (known.empty() ? "" : ", ") + std::to_string(config.cameras[i].id);
    }
    throw SettingsError(fmt::format("{}: has no camera {}; known: {}", settings_file, camera_id, known));
  }
};

struct RawFormat {
  std::string pixel_format, size;
  int width = 0, height = 0;

  void add_to(CLI::App& command) {
    command.add_option("--pixel-format", pixel_format, "of raw frames, such as uyvy or bayer_rg8");
    command.add_option("--size", size, "of raw frames, such as 780x580");
  }
  void parse() {
    if (size.empty()) return;
    char rest = 0;
    if (std::sscanf(size.c_str(), "%dx%d%c", &width, &height, &rest) != 2) {
      throw SettingsError(fmt::format("--size: \"{}\" is not allowed; expected WIDTHxHEIGHT", size));
    }
  }
};

/// A file to write, or standard output for "-".
class Output {
 public:
  explicit Output(const std::string& file) {
    if (file == "-") return;
    file_.open(file, std::ios::binary);
    if (!file_) throw StorageError(fmt::format("cannot write {}: {}", file, std::strerror(errno)));
  }
  std::ostream& stream() { return file_.is_open() ? file_ : std::cout; }

 private:
  std::ofstream file_;
};

/// Writes what became of a calibration: the calibration to `calibration_file` when there is one, the whole
/// report to `report_file`, unless they are empty, and what a person wants to know.
int tell_calibration(const Json& report, const std::string& calibration_file, const std::string& report_file,
                     bool as_json, std::string (*text)(const Json&)) {
  const auto write = [](const std::string& file, const Json& json) {
    Output output(file);
    output.stream() << json.dump(2) << std::endl;
    if (!output.stream()) throw StorageError(fmt::format("cannot write {}: {}", file, std::strerror(errno)));
  };
  if (!report_file.empty()) write(report_file, report);
  if (!calibration_file.empty() && report.at("found") == true)
    write(calibration_file, report.at("calibration"));
  // Standard output belongs to the file that is written there.
  (calibration_file == "-" || report_file == "-" ? std::cerr : std::cout)
      << (as_json ? report.dump(2) + "\n" : text(report));
  return report.at("accepted") == true ? EXIT_SUCCESS : EXIT_FAILURE;
}

void print_bench(const std::vector<BenchResult>& results, bool as_json) {
  if (as_json) {
    Json out = Json::array();
    for (const BenchResult& result : results) {
      Json stages = Json::array();
      for (const StageTiming& stage : result.stages) {
        stages.push_back({{"stage", stage.stage},
                          {"min_us", stage.min_us},
                          {"median_us", stage.median_us},
                          {"p99_us", stage.p99_us}});
      }
      out.push_back({{"pixel_format", result.pixel_format},
                     {"width", result.width},
                     {"height", result.height},
                     {"robots", result.robots},
                     {"balls", result.balls},
                     {"stages", stages}});
    }
    std::cout << out.dump(2) << "\n";
    return;
  }
  for (const BenchResult& result : results) {
    fmt::print("{}x{} {}: {} robots, {} balls in the last frame\n  {:<16}{:>12}{:>12}{:>12}\n", result.width,
               result.height, result.pixel_format, result.robots, result.balls, "stage", "min us",
               "median us", "p99 us");
    for (const StageTiming& stage : result.stages) {
      fmt::print("  {:<16}{:>12.1f}{:>12.1f}{:>12.1f}\n", stage.stage, stage.min_us, stage.median_us,
                 stage.p99_us);
    }
  }
}

int run(CLI::App& app, int argc, char** argv) {
  app.set_version_flag("--version", std::string("ssl-visionctl ") + kVersion);
  app.require_subcommand(1);
  std::function<int()> act;

  std::string daemon = "http://127.0.0.1:8090";
  app.add_option("--daemon", daemon, "address of the daemon's panel")->capture_default_str();

  bool as_json = false;
  CLI::App* status = app.add_subcommand("status", "how the daemon is");
  status->add_flag("--json", as_json, "as the API gives it");
  status->callback([&] {
    act = [&] {
      const Json answer = Client(daemon).get_json("/api/status");
      std::cout << (as_json ? answer.dump(2) + "\n" : status_text(answer));
      return EXIT_SUCCESS;
    };
  });

  double interval_s = 1;
  int count = 0;
  CLI::App* watch = app.add_subcommand("watch", "the status again and again");
  watch->add_option("--interval", interval_s, "seconds between two")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  watch->add_option("--count", count, "so many times; 0: until interrupted")->check(CLI::NonNegativeNumber);
  watch->callback([&] {
    act = [&] {
      for (int i = 0; count == 0 || i < count; ++i) {
        if (i > 0) std::this_thread::sleep_for(std::chrono::duration<double>(interval_s));
        std::cout << status_text(Client(daemon).get_json("/api/status")) << std::endl;
      }
      return EXIT_SUCCESS;
    };
  });

  int snapshot_camera = 0;
  std::string snapshot_file;
  CLI::App* snapshot = app.add_subcommand("snapshot", "the newest picture of a camera as a JPEG file");
  snapshot->add_option("--camera", snapshot_camera, "id of the camera")->capture_default_str();
  snapshot->add_option("--output", snapshot_file, "file to write; -: standard output")->required();
  snapshot->callback([&] {
    act = [&] {
      const std::string jpeg =
          Client(daemon).get(fmt::format("/api/cameras/{}/snapshot.jpg", snapshot_camera));
      Output output(snapshot_file);
      output.stream() << jpeg;
      return EXIT_SUCCESS;
    };
  });

  int controls_camera = 0;
  bool for_now = false;
  std::vector<std::string> assignments;
  CLI::App* controls = app.add_subcommand(
      "controls", "what can be set at a camera itself; with NAME=VALUE sets it, with NAME does an action");
  controls->add_option("assignments", assignments, "NAME=VALUE, or the NAME of an action");
  controls->add_option("--camera", controls_camera, "id of the camera")->capture_default_str();
  controls->add_flag("--for-now", for_now, "do not save it in the settings");
  controls->add_flag("--json", as_json, "as the API gives it");
  controls->callback([&] {
    act = [&] {
      const Client client(daemon);
      Json shown = Json::array();
      for (const std::string& one : assignments)
        shown.push_back(set_control(client, controls_camera, one, !for_now));
      if (assignments.empty())
        shown = client.get_json(fmt::format("/api/cameras/{}/controls", controls_camera)).at("controls");
      std::cout << (as_json ? shown.dump(2) + "\n" : controls_text(shown));
      return EXIT_SUCCESS;
    };
  });

  CLI::App* sources =
      app.add_subcommand("sources", "cameras that the daemon could open, with their settings");
  sources->add_flag("--json", as_json, "as the API gives it");
  sources->callback([&] {
    act = [&] {
      const Json found = Client(daemon).get_json("/api/sources").at("sources");
      std::cout << (as_json ? found.dump(2) + "\n" : found_cameras_text(found));
      return EXIT_SUCCESS;
    };
  });

  CLI::App* history =
      app.add_subcommand("history", "what was changed in the daemon's settings, newest first");
  history->add_flag("--json", as_json, "as the API gives it");
  history->callback([&] {
    act = [&] {
      const Json steps = Client(daemon).get_json("/api/settings/history");
      std::cout << (as_json ? steps.dump(2) + "\n" : history_text(steps));
      return EXIT_SUCCESS;
    };
  });

  std::uint64_t undo_revision = 0;
  CLI::App* undo = app.add_subcommand("undo", "take one step of the history back; what came after it stays");
  undo->add_option("revision", undo_revision, "number of the step, as `history` shows it")->required();
  undo->callback([&] {
    act = [&] {
      const Json answer = Client(daemon).post("/api/settings/undo", {{"revision", undo_revision}});
      std::cout << fmt::format("Taken back; the settings are at revision {}.\n",
                               answer.at("revision").get<std::uint64_t>());
      return EXIT_SUCCESS;
    };
  });

  CameraChoice choice;
  RawFormat raw;
  std::string input, output = "-";
  CLI::App* process =
      app.add_subcommand("process", "run a camera's stack over recorded input, without a daemon");
  choice.add_to(*process);
  process->add_option("--input", input, "picture, raw frame, video, or a folder of pictures or raw frames")
      ->required();
  raw.add_to(*process);
  process->add_option("--output", output, "one JSON object a line for each frame; -: standard output")
      ->capture_default_str();
  process->callback([&] {
    act = [&] {
      raw.parse();
      const Config config = choice.config();
      Output file(output);
      const int unreadable =
          process_recording(config, choice.index_in(config), {input, raw.pixel_format, raw.width, raw.height},
                            file.stream(), std::cerr);
      if (unreadable > 0) std::cerr << unreadable << " frames could not be read and were skipped\n";
      return EXIT_SUCCESS;
    };
  });

  int frames = 20, rounds = 10;
  std::string bench_input;
  CLI::App* bench = app.add_subcommand("bench", "time every stage on simulated or given frames");
  choice.add_to(*bench);
  bench->add_option("--input", bench_input, "frames to use instead of simulated ones");
  raw.add_to(*bench);
  bench->add_option("--frames", frames, "simulated frames of each kind")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  bench->add_option("--rounds", rounds, "runs over all frames")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  bench->add_flag("--json", as_json, "as JSON");
  bench->callback([&] {
    act = [&] {
      raw.parse();
      const Config config = choice.config();
      const std::size_t index = choice.index_in(config);
      print_bench(bench_input.empty()
                      ? bench_simulated(config, index, frames, rounds)
                      : std::vector{bench_recorded(config, index, bench_input, raw.pixel_format, raw.width,
                                                   raw.height, rounds)},
                  as_json);
      return EXIT_SUCCESS;
    };
  });

  SimulateOptions simulation;
  CLI::App* simulator = app.add_subcommand("simulate", "write simulated frames with their truth");
  choice.add_to(*simulator);
  simulator->add_option("--frames", simulation.frames, "how many")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  simulator
      ->add_option("--start", simulation.start_s,
                   "time of the first frame in seconds: other times, other places")
      ->capture_default_str();
  simulator->add_flag("--raw", simulation.raw,
                      "frames as the camera's bytes (.raw) instead of .ppm pictures");
  simulator->add_option("--output", simulation.folder, "folder to write to")->required();
  simulator->callback([&] {
    act = [&] {
      const Config config = choice.config();
      const std::size_t index = choice.index_in(config);
      const CameraSettings& camera = config.cameras[index];
      if (camera.source.at("backend") != "simulator") {
        throw SettingsError(
            fmt::format("{}: /cameras/{}/source/backend: {} is not allowed; expected \"simulator\"",
                        choice.settings_file, index, camera.source.at("backend").dump()));
      }
      simulation.source = camera.source;
      simulation.source.erase("backend");
      simulation.context = {static_cast<std::uint32_t>(camera.id), *make_world(config, index).scene};
      simulate(simulation);
      return EXIT_SUCCESS;
    };
  });

  std::string detections_file, truth_file, suite_file;
  AccuracyOptions suite_options;
  bool as_markdown = false;
  CLI::App* score_command = app.add_subcommand(
      "score", "compare detections with the truth, or run a suite of conditions and compare them all");
  CLI::Option* detections =
      score_command->add_option("--detections", detections_file, "file that `process` wrote");
  CLI::Option* truth = score_command->add_option("--truth", truth_file, "truth.jsonl that `simulate` wrote");
  CLI::Option* suite = score_command->add_option("--suite", suite_file,
                                                 "file of conditions, such as tests/golden/accuracy.json");
  detections->needs(truth);
  truth->needs(detections);
  suite->excludes(detections)->excludes(truth);
  score_command->add_option("--only", suite_options.only, "conditions of the suite, by name")->needs(suite);
  score_command->add_option("--frames", suite_options.frames, "pictures for each condition")
      ->check(CLI::Range(1, 100000))
      ->needs(suite);
  CLI::Option* markdown =
      score_command->add_flag("--markdown", as_markdown, "the suite's tables as Markdown")->needs(suite);
  score_command->add_flag("--json", as_json, "as JSON")->excludes(markdown);
  score_command->callback([&] {
    if (suite_file.empty() && detections_file.empty()) {
      throw CLI::ValidationError("score", "needs --suite, or --detections and --truth");
    }
    act = [&] {
      if (suite_file.empty()) {
        const Score result = score_files(detections_file, truth_file);
        std::cout << (as_json ? score_json(result).dump(2) + "\n" : score_text(result));
        return EXIT_SUCCESS;
      }
      suite_options.done = [](const AccuracyRow& row) {
        std::cerr << row.condition << ", " << row.pixel_format
                  << (row.failures.empty() ? "\n" : ": FAILED\n");
      };
      const AccuracyReport report = run_accuracy_suite(read_accuracy_suite(suite_file), suite_options);
      std::cout << (as_json ? accuracy_json(report).dump(2) + "\n" : accuracy_text(report, as_markdown));
      return report.passed() ? EXIT_SUCCESS : EXIT_FAILURE;
    };
  });

  CalibrateWords words;
  std::string calibrate_input, field_name, previous_file, calibration_file, report_file;
  int calibrate_camera = 0;
  std::vector<int> together_cameras;
  double together_s = 10;
  bool together = false, accept = false, force = false;
  CLI::App* calibrate = app.add_subcommand(
      "calibrate", "find where a camera hangs, from its picture: of the daemon's camera, or of files");
  CLI::Option* of_daemon = calibrate->add_option("--camera", calibrate_camera, "id of the daemon's camera");
  CLI::Option* of_files = calibrate->add_option(
      "--input", calibrate_input, "picture, raw frame, video, or a folder; their mean is taken");
  of_files->excludes(of_daemon);
  CLI::Option* of_several =
      calibrate
          ->add_flag("--together", together,
                     "refine several calibrated cameras of the daemon, so that they agree where they overlap")
          ->excludes(of_daemon)
          ->excludes(of_files);
  calibrate
      ->add_option("--cameras", together_cameras,
                   "ids of those, such as 0,1; all that are calibrated unless said")
      ->delimiter(',')
      ->needs(of_several);
  calibrate->add_option("--seconds", together_s, "how long robots are looked for that two of them see")
      ->check(CLI::Range(0.0, 600.0))
      ->capture_default_str()
      ->needs(of_several);
  raw.add_to(*calibrate);
  CLI::Option* field_option =
      calibrate
          ->add_option("--field", field_name, "division-a, division-b, or a settings file whose field it is")
          ->needs(of_files);
  calibrate->add_option("--points", words.points_file,
                        "file of points: [{\"x\": px, \"y\": px, \"name\": may be left out}, ...]");
  calibrate->add_option("--frames", words.frames, "pictures to take the mean of; 10 unless said")
      ->check(CLI::Range(1, 100));
  calibrate->add_option("--height", words.height_mm,
                        "the camera's height above the floor in mm, if measured");
  calibrate->add_option("--height-sigma", words.height_sigma_mm, "how exactly, in mm; 20 unless said");
  calibrate->add_option("--focal", words.focal_px, "focal length in px, if known");
  calibrate
      ->add_option("--plus-x", words.plus_x,
                   "side of the picture where the +x half lies: right, left, up or down")
      ->check(CLI::IsMember({"right", "left", "up", "down"}));
  calibrate
      ->add_option("--lines", words.lines,
                   "what the field's sizes were measured to: outer-edge or middle; found out unless said")
      ->check(CLI::IsMember({"outer-edge", "middle"}));
  calibrate->add_option("--previous", previous_file, "calibration to compare with")->needs(of_files);
  CLI::Option* output_option = calibrate->add_option(
      "--output", calibration_file, "calibration to write, as settings have it; -: standard output");
  calibrate->add_option("--report", report_file, "file for all figures");
  calibrate->add_flag("--json", as_json, "print the report as JSON");
  calibrate->add_flag("--accept", accept, "put it into force when it is good enough")->excludes(of_files);
  calibrate->add_flag("--force", force, "also while the game runs")->excludes(of_files);
  for (const char* of_one_camera :
       {"--points", "--height", "--height-sigma", "--focal", "--plus-x", "--lines", "--output"})
    of_several->excludes(calibrate->get_option(of_one_camera));
  calibrate->callback([&] {
    if (of_daemon->empty() && !together &&
        (of_files->empty() || field_option->empty() || output_option->empty())) {
      throw CLI::ValidationError("calibrate",
                                 "needs --camera, or --together, or --input, --field and --output");
    }
    act = [&] {
      if (together) {
        const Client client(daemon);
        const Json report = calibrate_together(client, {{"cameras", together_cameras},
                                                        {"frames", words.frames.value_or(10)},
                                                        {"seconds", together_s},
                                                        {"force", force}});
        const int exit_code = tell_calibration(report, "", report_file, as_json, joint_calibration_text);
        if (accept && exit_code == EXIT_SUCCESS) {
          client.post("/api/calibration/accept", {{"force", force}});
          std::cerr << "They are in force.\n";
        }
        return exit_code;
      }
      Json asked = calibration_request(words);
      if (!of_daemon->empty()) {
        const Client client(daemon);
        asked["force"] = force;
        const Json report = calibrate_running(client, calibrate_camera, asked);
        const int exit_code =
            tell_calibration(report, calibration_file, report_file, as_json, calibration_text);
        if (accept && exit_code == EXIT_SUCCESS) {
          client.post(fmt::format("/api/cameras/{}/calibration/accept", calibrate_camera),
                      {{"force", force}});
          std::cerr << "It is in force.\n";
        }
        return exit_code;
      }
      raw.parse();
      const CalibrationRequest request = read_calibration_request(asked);
      const FieldSize field = field_named(field_name);
      std::optional<CameraCalibration> previous;
      if (!previous_file.empty()) previous = read_calibration(previous_file);
      const CalibrationReport report = calibrate_recording(
          {calibrate_input, raw.pixel_format, raw.width, raw.height}, request, field, previous, std::cerr);
      return tell_calibration(report_json(report), calibration_file, report_file, as_json, calibration_text);
    };
  });

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? EXIT_SUCCESS : EX_USAGE;
  }
  return act();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Asks a running ssl-visiond, or runs its pipeline over files."};
  try {
    return run(app, argc, argv);
  } catch (const SettingsError& error) {
    std::cerr << "ssl-visionctl: " << error.what() << "\n";
    return EX_CONFIG;
  } catch (const std::exception& error) {
    std::cerr << "ssl-visionctl: " << error.what() << "\n";
    return EXIT_FAILURE;
  }
}
