// SPDX-License-Identifier: Apache-2.0
#include "ctl/commands/commands.h"
#include "ctl/diagnostics_text.h"
#include "ctl/field_text.h"
#include "ctl/packets_text.h"
#include "ctl/status_text.h"
#include "ctl/terminal_text.h"

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <thread>

#include <fmt/format.h>

namespace sslv {

void add_status(CommandLine& line) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* command = line.app.add_subcommand("status", "show the service's cameras, network and rates");
  add_json_flag(command, *as_json);
  line.on(command, [&line, as_json] {
    print_answer(line.client().get_json("/api/status"), *as_json, status_text);
    return EXIT_SUCCESS;
  });
}

void add_watch(CommandLine& line) {
  struct Options {
    double interval_s = 1;
    int count = 0;
    std::string what = "status";
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand("watch", "show the status, or the field, repeatedly");
  command->add_option("what", o->what, "status or field")
      ->check(CLI::IsMember({"status", "field"}))
      ->capture_default_str();
  command->add_option("--interval", o->interval_s, "seconds between two outputs")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command->add_option("--count", o->count, "number of outputs; 0: until interrupted")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--json", o->as_json, "as the API gives it, one per line");
  line.on(command, [&line, o] {
    const Client client = line.client();
    for (int i = 0; o->count == 0 || i < o->count; ++i) {
      if (i > 0) std::this_thread::sleep_for(std::chrono::duration<double>(o->interval_s));
      const bool is_field = o->what == "field";
      const Json answer = client.get_json(is_field ? "/api/field" : "/api/status");
      std::cout << (o->as_json ? terminal_json(answer, -1)
                               : answer_text(answer, false, is_field ? field_text : status_text))
                << std::endl;
    }
    return EXIT_SUCCESS;
  });
}

void add_cameras(CommandLine& line) {
  struct Options {
    int camera_id = 0;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* cameras = line.app.add_subcommand("cameras", "list the cameras, one line each");
  cameras->require_subcommand(0, 1);
  add_json_flag(cameras, o->as_json);
  cameras->callback([&line, o, cameras] {
    if (!cameras->get_subcommands().empty()) return;
    line.act = [&line, o] {
      print_answer(line.client().get_json("/api/cameras"), o->as_json, cameras_text);
      return EXIT_SUCCESS;
    };
  });
  CLI::App* reopen = cameras->add_subcommand("reopen", "try to open a lost camera now");
  reopen->add_option("camera", o->camera_id, "id of the camera")->required();
  add_json_flag(reopen, o->as_json);
  line.on(reopen, [&line, o] {
    const std::string path = fmt::format("/api/cameras/{}/reopen", o->camera_id);
    print_answer(line.client().post(path, Json::object()), o->as_json,
                 [](const Json& camera) { return cameras_text(Json::array({camera})); });
    return EXIT_SUCCESS;
  });
}

void add_field(CommandLine& line) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* field = line.app.add_subcommand(
      "field", "what all cameras together see: robots, balls, kicks, agreement; the league's fields");
  field->require_subcommand(0, 1);
  add_json_flag(field, *as_json);
  field->callback([&line, as_json, field] {
    if (!field->get_subcommands().empty()) return;
    line.act = [&line, as_json] {
      print_answer(line.client().get_json("/api/field"), *as_json, field_text);
      return EXIT_SUCCESS;
    };
  });
  const auto add = [&](const char* name, const char* help, const char* path,
                       std::string (*text)(const Json&)) {
    const auto part_as_json = std::make_shared<bool>(false);
    CLI::App* part = field->add_subcommand(name, help);
    add_json_flag(part, *part_as_json);
    line.on(part, [&line, part_as_json, path, text] {
      print_answer(line.client().get_json(path), *part_as_json, text);
      return EXIT_SUCCESS;
    });
  };
  add("kicks", "the last kicks, the newest first", "/api/field/kicks", kicks_text);
  add("agreement", "what cameras do not agree on: places, times, robots' heights", "/api/field/agreement",
      agreement_text);
  add_field_presets(line, field);
}

void add_alerts(CommandLine& line) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* command = line.app.add_subcommand(
      "alerts", "what is wrong and what to do about it, the worst first; exit code 1 when something is bad");
  add_json_flag(command, *as_json);
  line.on(command, [&line, as_json] {
    const Json alerts = worst_first(line.client().get_json("/api/status").at("alerts"));
    print_answer(alerts, *as_json, alerts_text);
    return any_bad(alerts) ? EXIT_FAILURE : EXIT_SUCCESS;
  });
}

void add_events(CommandLine& line) {
  struct Options {
    bool only_bad = false, as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand(
      "events", "alerts and what was done in the last 24 hours: when, how long, what; the newest first");
  command->add_flag("--bad", o->only_bad, "only alerts that are or were bad");
  add_json_flag(command, o->as_json);
  line.on(command, [&line, o] {
    Json events = line.client().get_json("/api/events");
    if (o->only_bad) events["entries"] = only_bad(events.at("entries"));
    print_answer(events, o->as_json, events_text);
    return EXIT_SUCCESS;
  });
}

void add_check(CommandLine& line) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* command =
      line.app.add_subcommand("check", "whether a match may begin: GO, or NO-GO and exit code 1");
  add_json_flag(command, *as_json);
  line.on(command, [&line, as_json] {
    const Json checks = line.client().get_json("/api/checks");
    print_answer(checks, *as_json, checks_text);
    return checks.at("go") == true ? EXIT_SUCCESS : EXIT_FAILURE;
  });
}

void add_diagnostics(CommandLine& line) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* command =
      line.app.add_subcommand("diagnostics", "show the computer, its clock, and how long each stage takes");
  add_json_flag(command, *as_json);
  line.on(command, [&line, as_json] {
    print_answer(line.client().get_json("/api/diagnostics"), *as_json, diagnostics_text);
    return EXIT_SUCCESS;
  });
}

void add_packets(CommandLine& line) {
  const auto as_json = std::make_shared<bool>(false);
  CLI::App* command = line.app.add_subcommand(
      "packets",
      "the newest packets that the service heard itself send, decoded, and who listens on its computer");
  add_json_flag(command, *as_json);
  line.on(command, [&line, as_json] {
    const Client client = line.client();
    Json packets = client.get_json("/api/network/packets");
    packets["listeners"] = client.get_json("/api/network/listeners");
    print_answer(packets, *as_json, packets_text);
    return EXIT_SUCCESS;
  });
}

void add_log(CommandLine& line) {
  struct Options {
    std::string level = "debug";
    bool follow = false, as_json = false;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command = line.app.add_subcommand("log", "show the newest lines of the service's log");
  command->add_option("--level", o->level, "lowest level to show: debug, info, warning or error")
      ->check(CLI::IsMember({"debug", "info", "warning", "error"}))
      ->capture_default_str();
  command->add_flag("--follow", o->follow, "keep showing new lines, until interrupted");
  command->add_flag("--json", o->as_json, "one object per line, as the API gives it");
  line.on(command, [&line, o] {
    const Client client = line.client();
    std::uint64_t next = 0;
    do {
      const Json answer = client.get_json(fmt::format("/api/log?after={}&level={}", next, o->level));
      for (const Json& one : answer.at("lines"))
        std::cout << (o->as_json ? terminal_json(one, -1) + "\n" : answer_text(one, false, log_line_text));
      std::cout << std::flush;
      next = answer.at("next").get<std::uint64_t>();
      if (o->follow) std::this_thread::sleep_for(std::chrono::milliseconds(500));
    } while (o->follow);
    return EXIT_SUCCESS;
  });
}

void add_support_bundle(CommandLine& line) {
  struct Options {
    std::string file, clip;
  };
  const auto o = std::make_shared<Options>();
  CLI::App* command =
      line.app.add_subcommand("support-bundle", "save everything that a bug report needs in one file");
  command->add_option("file", o->file,
                      "file to write; -: standard output; default: ssl-visiond-support.tar.gz, with a clip "
                      "ssl-visiond-support.tar");
  command->add_option("--clip", o->clip,
                      "name of a clip to put into it: it shows the people on and around the field");
  line.on(command, [&line, o] {
    const bool has_clip = !o->clip.empty();
    const std::string name = !o->file.empty() ? o->file
                             : has_clip       ? "ssl-visiond-support.tar"
                                              : "ssl-visiond-support.tar.gz";
    const std::string path = has_clip ? "/api/support?clip=" + path_part(o->clip) : "/api/support";
    const Client client = line.client();
    write_pieces(name, [&](const TakePiece& take) { client.get_pieces(path, take); });
    return EXIT_SUCCESS;
  });
}

}  // namespace sslv
