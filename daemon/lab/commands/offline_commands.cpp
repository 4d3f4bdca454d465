// SPDX-License-Identifier: Apache-2.0
#include "config/backends.h"
#include "lab/accuracy.h"
#include "lab/bench.h"
#include "lab/commands/commands.h"
#include "lab/commands/offline_options.h"
#include "lab/process.h"
#include "lab/score.h"
#include "lab/simulate.h"
#include "lab/track_log.h"
#include "lab/track_score.h"
#include "settings/migrations.h"
#include "settings/state_folder.h"

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace sslv {

void add_process(CommandLine& line) {
  struct Options {
    CameraChoice choice;
    RawFormat raw;
    std::string input, output = "-";
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command =
      line.app.add_subcommand("process", "run a camera's stack over recorded input, without a daemon");
  o->choice.add_to(command);
  o->choice.add_lut_to(command);
  command->add_option("--input", o->input, "image, raw frame, video, or a folder of images or raw frames")
      ->required();
  o->raw.add_to(command);
  command->add_option("--output", o->output, "one JSON object a line for each frame; -: standard output")
      ->capture_default_str();
  line.on(command, [o] {
    o->raw.parse();
    const Config config = o->choice.config();
    Output file(o->output);
    const int unreadable = process_recording(config, o->choice.index_in(config),
                                             {o->input, o->raw.pixel_format, o->raw.width, o->raw.height},
                                             file.stream(), std::cerr);
    if (unreadable > 0) std::cerr << unreadable << " frames could not be read and were skipped\n";
    return EXIT_SUCCESS;
  });
}

void add_bench(CommandLine& line) {
  struct Options {
    CameraChoice choice;
    RawFormat raw;
    std::string input;
    int frames = 20, rounds = 10;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand("bench", "time every stage on simulated or given frames");
  o->choice.add_to(command);
  o->choice.add_lut_to(command);
  command->add_option("--input", o->input, "frames to use instead of simulated ones");
  o->raw.add_to(command);
  command->add_option("--frames", o->frames, "simulated frames of each kind")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_option("--rounds", o->rounds, "runs over all frames")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_flag("--json", o->as_json, "as JSON");
  line.on(command, [o] {
    o->raw.parse();
    const Config config = o->choice.config();
    const std::size_t index = o->choice.index_in(config);
    const std::vector<BenchResult> results =
        o->input.empty() ? bench_simulated(config, index, o->frames, o->rounds)
                         : std::vector{bench_recorded(config, index, o->input, o->raw.pixel_format,
                                                      o->raw.width, o->raw.height, o->rounds)};
    std::cout << (o->as_json ? json_text(bench_json(results), 2) + "\n" : bench_text(results));
    return EXIT_SUCCESS;
  });
}

void add_simulate(CommandLine& line) {
  struct Options {
    CameraChoice choice;
    SimulateOptions simulation;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand("simulate", "write simulated frames with their truth");
  o->choice.add_to(command);
  command->add_option("--frames", o->simulation.frames, "how many")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  command
      ->add_option("--start", o->simulation.start_s,
                   "time of the first frame in seconds: other times, other places")
      ->capture_default_str();
  command->add_flag("--raw", o->simulation.raw, "frames as the camera's bytes (.raw) instead of .ppm images");
  command->add_option("--output", o->simulation.folder, "folder to write to")->required();
  line.on(command, [o] {
    const Config config = o->choice.config();
    const std::size_t index = o->choice.index_in(config);
    const CameraSettings& camera = config.cameras[index];
    if (camera.source.at("backend") != "simulator") {
      throw SettingsError(
          fmt::format("{}: /cameras/{}/source/backend: {} is not allowed; expected \"simulator\"",
                      o->choice.settings_file, index, json_text(camera.source.at("backend"))));
    }
    o->simulation.source = camera.source;
    o->simulation.source.erase("backend");
    o->simulation.context = {static_cast<std::uint32_t>(camera.id), *make_context(config, index).scene};
    simulate(o->simulation);
    return EXIT_SUCCESS;
  });
}

void add_track(CommandLine& line) {
  struct Options {
    std::filesystem::path log_file, settings_file;
    StageFolders stage_folders;
    std::string tracks_file;
    double later_s = 0;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand(
      "track", "track what cameras saw in a log of the league's logger: gaps and jumps before and after");
  command->add_option("--log", o->log_file, "the log, packed or not")->required();
  command->add_option("--config", o->settings_file, "settings whose field and field's stack are used");
  add_stages_options(command, o->stage_folders);
  command->add_option("--tracks", o->tracks_file,
                      "file for the tracks, a line for each packet; -: standard output");
  command
      ->add_option("--later", o->later_s,
                   "tracks as they are known so many seconds later, which are smoother; .25 is enough")
      ->check(CLI::Range(0.05, 2.0));
  command->add_flag("--json", o->as_json, "as JSON");
  line.on(command, [o] {
    add_stage_libraries(o->stage_folders, MissingStages::kRefused);
    Config config;
    if (o->settings_file.empty()) {
      config = read_config(Json::object());
    } else {
      config = read_config(up_to_date(read_json_file(o->settings_file), settings_migrations()));
    }
    std::optional<Output> tracks;
    if (!o->tracks_file.empty()) tracks.emplace(o->tracks_file);
    const TrackedLog log = track_log(o->log_file, config,
                                     {.later_s = o->later_s, .tracks = tracks ? &tracks->stream() : nullptr});
    if (tracks) tracks->finish();
    (o->tracks_file == "-" ? std::cerr : std::cout)
        << (o->as_json ? json_text(tracked_log_json(log), 2) + "\n" : tracked_log_text(log));
    return EXIT_SUCCESS;
  });
}

void add_score(CommandLine& line) {
  struct Options {
    std::string detections_file, truth_file, suite_file;
    ScoreOptions score;
    AccuracyOptions suite;
    double tracks_s = 0;
    bool as_markdown = false, as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand(
      "score",
      "compare detections, or a running daemon's tracks, with the truth, or run a suite of conditions and "
      "compare them all");
  CLI::Option* detections =
      command->add_option("--detections", o->detections_file, "file that `process` wrote");
  CLI::Option* truth =
      command->add_option("--truth", o->truth_file, "truth file that `simulate` or `annotate` wrote");
  CLI::Option* suite =
      command->add_option("--suite", o->suite_file, "file of conditions, such as tests/golden/accuracy.json");
  detections->needs(truth);
  truth->needs(detections);
  command
      ->add_option("--min-robot-share", o->score.min_robot_share,
                   "robots of which a smaller share is visible do not count")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->needs(detections);
  command
      ->add_option("--min-ball-share", o->score.min_ball_share,
                   "balls of which a smaller share is visible do not count")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->needs(detections);
  suite->excludes(detections)->excludes(truth);
  CLI::Option* tracks =
      command
          ->add_option("--tracks", o->tracks_s,
                       "listen for so many seconds to the tracks of a daemon whose cameras are simulated")
          ->check(CLI::Range(1.0, 86400.0))
          ->excludes(suite)
          ->excludes(detections);
  command->add_option("--only", o->suite.only, "conditions of the suite, by name")->needs(suite);
  command->add_option("--frames", o->suite.frames, "images for each condition")
      ->check(CLI::Range(1, 100000))
      ->needs(suite);
  const auto set_colors = [o](const std::string& name) {
    o->suite.colors = name == "learnt" ? AccuracyColors::kLearnt : AccuracyColors::kClicked;
  };
  command
      ->add_option_function<std::string>("--colors", set_colors,
                                         "make the colour tables of clicks, or learn them without any")
      ->check(CLI::IsMember({"clicked", "learnt"}))
      ->needs(suite);
  CLI::Option* markdown =
      command->add_flag("--markdown", o->as_markdown, "the suite's tables as Markdown")->needs(suite);
  command->add_flag("--json", o->as_json, "as JSON")->excludes(markdown);
  const auto score_two_files = [o] {
    const Score result = score_files(o->detections_file, o->truth_file, o->score);
    std::cout << (o->as_json ? json_text(score_json(result), 2) + "\n" : score_text(result));
    return EXIT_SUCCESS;
  };
  const auto run_suite = [o] {
    o->suite.done = [](const AccuracyRow& row) {
      std::cerr << row.condition << ", " << row.pixel_format << (row.failures.empty() ? "\n" : ": FAILED\n");
    };
    const AccuracyReport report = run_accuracy_suite(read_accuracy_suite(o->suite_file), o->suite);
    std::cout << (o->as_json ? json_text(accuracy_json(report), 2) + "\n"
                             : accuracy_text(report, o->as_markdown));
    return report.passed() ? EXIT_SUCCESS : EXIT_FAILURE;
  };
  const auto score_running = [&line, o] {
    leave_out_missing_stages();  // stages that only the daemon has
    const Config config = read_config(line.client().get_json("/api/settings").at("settings"));
    const SimulatedWorld world = simulated_world(config);
    const TrackScorer scorer = score_tracks(config, world, o->tracks_s);
    std::cout << (o->as_json ? json_text(track_score_json(scorer), 2) + "\n" : track_score_text(scorer));
    return EXIT_SUCCESS;
  };
  command->callback([&line, o, tracks, score_two_files, run_suite, score_running] {
    if (o->suite_file.empty() && o->detections_file.empty() && tracks->count() == 0)
      throw CLI::ValidationError("score", "needs --suite, --tracks, or --detections and --truth");
    if (tracks->count() > 0) {
      line.act = score_running;
    } else if (o->suite_file.empty()) {
      line.act = score_two_files;
    } else {
      line.act = run_suite;
    }
  });
}

}  // namespace sslv
