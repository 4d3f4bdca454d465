// SPDX-License-Identifier: Apache-2.0
#include "base/error.h"
#include "lab/commands/commands.h"
#include "lab/commands/offline_options.h"
#include "lab/match_log.h"
#include "net/multicast.h"
#include "net/referee_listener.h"
#include "net/tracker_settings.h"
#include "recording/match_log_convert.h"
#include "recording/match_log_player.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

namespace sslv {
namespace {

void add_file_commands(CommandLine& line, CLI::App* group) {
  struct Options {
    std::filesystem::path log, to;
    bool as_json = false;
  };
  const auto o = std::make_shared<Options>();
  auto* info = group->add_subcommand(
      "info", "what a log holds: messages, times, events; makes its index if it has none");
  info->add_option("log", o->log, "the log, packed or not")->required();
  add_json_flag(info, o->as_json);
  line.on(info, [o] {
    print_answer(match_log_info_json(o->log, match_log_index(o->log)), o->as_json, match_log_info_text);
    return EXIT_SUCCESS;
  });

  auto* convert = group->add_subcommand("convert",
                                        "write a log again: .log.gz in which programs can go to any time, or "
                                        "plain .log with the league's index");
  convert->add_option("log", o->log, "the log, packed or not")->required();
  convert->add_option("to", o->to, "new file, which ends with .log.gz or .log")->required();
  line.on(convert, [o] {
    const ConvertedMatchLog done = convert_match_log(o->log, o->to);
    std::cout << fmt::format("{} messages\n", done.messages);
    if (done.problem.empty()) return EXIT_SUCCESS;
    std::cerr << done.problem << "\n";
    return EXIT_FAILURE;
  });

  auto* repair =
      group->add_subcommand("repair", "make an unfinished or damaged log whole, and keep the damaged file");
  repair->add_option("log", o->log, "the log")->required();
  line.on(repair, [o] {
    std::cout << repair_any_log(o->log) << "\n";
    return EXIT_SUCCESS;
  });
}

/// Whether teams and referees receive this group: one of the league's, or a broadcast address.
bool is_the_leagues(const std::string& group) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address_v4(group, error);
  return group == MulticastSettings{}.group || group == RefereeSettings{}.group ||
         group == TrackerSettings{}.group || (!error && !address.is_multicast());
}

void add_play(CommandLine& line, CLI::App* group) {
  struct Options {
    std::filesystem::path log;
    PlayOptions play;
    double until_s = 0;
    bool insist = false;
  };
  const auto o = std::make_shared<Options>();
  o->play.group = "224.5.23.200";
  auto* play = group->add_subcommand("play", "send a log's packets again, for programs that listen");
  play->add_option("log", o->log, "the log, packed or not")->required();
  play->add_option("--speed", o->play.speed, "times as fast")
      ->check(kFinite)
      ->check(CLI::Range(MatchLogPlayer::kMinSpeed, MatchLogPlayer::kMaxSpeed))
      ->capture_default_str();
  play->add_option("--from", o->play.from_s, "s since the log's beginning")->check(kFinite);
  CLI::Option* until = play->add_option("--until", o->until_s, "s since the log's beginning")->check(kFinite);
  play->add_option("--longest-gap", o->play.longest_gap_s, "s; longer gaps, such as breaks, are cut to that")
      ->check(kFinite);
  play->add_option("--group", o->play.group, "multicast group or broadcast address to send to")
      ->capture_default_str();
  play->add_option("--vision-port", o->play.vision_port, "instead of the league's")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  play->add_option("--referee-port", o->play.referee_port, "likewise")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  play->add_option("--tracker-port", o->play.tracker_port, "likewise")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  play->add_option("--interface", o->play.interface,
                   "network card's name or address; default: the system's routes choose");
  play->add_flag("--insist", o->insist, "send to a group that the teams of a match listen to");
  line.on(play, [o, until] {
    if (is_the_leagues(o->play.group) && !o->insist)
      throw SettingsError(
          fmt::format("--group: teams listen to {}: they would take the log for the match; --insist "
                      "sends there all the same",
                      o->play.group));
    if (until->count() > 0) o->play.until_s = o->until_s;
    const Played played = play_match_log(o->log, o->play);
    std::cerr << fmt::format("\r{} vision, {} referee, {} tracked packets sent\n", played.vision,
                             played.referee, played.tracked);
    if (played.problem.empty()) return EXIT_SUCCESS;
    std::cerr << played.problem << "\n";
    return EXIT_FAILURE;
  });
}

}  // namespace

void add_match_log(CommandLine& line) {
  auto* group = line.app.add_subcommand("match-log", "look into logs of the league, change and play them");
  group->require_subcommand(1);
  add_file_commands(line, group);
  add_play(line, group);
}

}  // namespace sslv
