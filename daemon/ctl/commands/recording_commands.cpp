// SPDX-License-Identifier: Apache-2.0
// What a running daemon records; ssl-visionlab works on the files.
#include "base/error.h"
#include "ctl/commands/commands.h"
#include "ctl/commands/laboratory.h"
#include "ctl/recordings_text.h"

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <thread>

namespace sslv {
namespace {

/// Waits until the daemon has written the requested clip. Returns its name. Throws StorageError.
std::string written_clip(const Client& client) {
  for (;;) {
    const Json now = client.get_json("/api/recordings/clips").at("clip");
    const std::string state = now.at("state").get<std::string>();
    if (state == "failed") throw StorageError(now.at("error").get<std::string>());
    if (state == "idle") return now.at("name").get<std::string>();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

}  // namespace

void add_match_log(CommandLine& line) {
  auto* group = line.app.add_subcommand("match-log", "record matches");
  group->require_subcommand(1);
  struct Options {
    std::string name;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  auto* list = group->add_subcommand("list", "what is recorded now, and the logs that the service keeps");
  add_json_flag(list, o->as_json);
  line.on(list, [&line, o] {
    print_answer(line.client().get_json("/api/recordings"), o->as_json, recordings_text);
    return EXIT_SUCCESS;
  });
  auto* start = group->add_subcommand("start", "record from now on, whatever the game controller says");
  start->add_option("--name", o->name, "becomes a part of the file's name");
  line.on(start, [&line, o] {
    Json body{{"record", true}};
    if (!o->name.empty()) body["name"] = o->name;
    std::cout
        << line.client().post("/api/recordings/match-log", body).at("match_log").at("name").get<std::string>()
        << "\n";
    return EXIT_SUCCESS;
  });
  auto* stop = group->add_subcommand("stop", "end what is recorded");
  line.on(stop, [&line] {
    line.client().post("/api/recordings/match-log", {{"record", false}});
    return EXIT_SUCCESS;
  });
  add_laboratory_commands(line, group, {"convert", "info", "play", "repair"});
}

void add_clip(CommandLine& line) {
  auto* group = line.app.add_subcommand("clip", "keep clips: the last seconds' raw frames");
  group->require_subcommand(1);
  struct KeepOptions {
    std::string name;
    double seconds = 0, seconds_after = 0;
    bool as_json = false;
  };
  const auto o = std::make_shared<KeepOptions>();
  auto* list =
      group->add_subcommand("list", "how far back the service's memory reaches, and the clips it keeps");
  add_json_flag(list, o->as_json);
  line.on(list, [&line, o] {
    print_answer(line.client().get_json("/api/recordings/clips"), o->as_json, clips_text);
    return EXIT_SUCCESS;
  });
  auto* keep =
      group->add_subcommand("keep", "write a clip of the last seconds; says its name when it is done");
  auto* seconds = keep->add_option("--seconds", o->seconds, "how far back; default: as the settings say");
  seconds->check(CLI::Range(0.5, 600.0));
  keep->add_option("--after", o->seconds_after, "s that it goes on from now")->check(CLI::Range(0.0, 600.0));
  keep->add_option("--name", o->name, "becomes a part of the file's name");
  line.on(keep, [&line, o, seconds] {
    Json body{{"seconds_after", o->seconds_after}};
    if (seconds->count() > 0) body["seconds"] = o->seconds;
    if (!o->name.empty()) body["name"] = o->name;
    line.client().post("/api/recordings/clips", body);
    std::cout << written_clip(line.client()) << "\n";
    return EXIT_SUCCESS;
  });
  add_laboratory_commands(line, group, {"export", "info"});
}

}  // namespace sslv
