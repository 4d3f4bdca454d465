// SPDX-License-Identifier: Apache-2.0
#include "lab/match_log.h"

#include "base/clock.h"
#include "ctl/recordings_text.h"
#include "ctl/table.h"
#include "net/multicast.h"
#include "recording/match_log_player.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <iostream>
#include <string_view>
#include <thread>

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

namespace sslv {
namespace {

constexpr double kNs = 1e-9;

std::string type_name(std::int32_t type) {
  switch (type) {
    case LoggedMessage::kVision2010: return "vision of 2010";
    case LoggedMessage::kReferee: return "referee";
    case LoggedMessage::kVision2014: return "vision";
    case LoggedMessage::kTracker2020: return "tracked";
    default: return fmt::format("type {}", type);
  }
}

MulticastSettings group_of(const PlayOptions& options, int port) {
  MulticastSettings settings;
  settings.group = options.group;
  settings.port = port;
  settings.interface = options.interface;
  return settings;
}

}  // namespace

Json match_log_info_json(const std::filesystem::path& log, const MatchLogIndex& index) {
  Json messages = Json::object(), events = Json::array();
  for (const auto& [type, count] : index.messages) messages[type_name(type)] = count;
  for (const MatchEvent& event : index.events) {
    events.push_back({{"time_s", static_cast<double>(event.time_ns - index.first_ns) * kNs},
                      {"kind", name_of(event.kind)},
                      {"text", event.text}});
  }
  return {{"log", log.string()},
          {"bytes", index.file_bytes},
          {"begin_s", static_cast<double>(index.first_ns) * kNs},
          {"seconds", static_cast<double>(index.last_ns - index.first_ns) * kNs},
          {"messages", std::move(messages)},
          {"places_to_begin", index.points.size() + 1},
          {"events", std::move(events)},
          {"problem", index.problem}};
}

std::string match_log_info_text(const Json& info) {
  std::string out =
      fmt::format("{}\n  begins {}, lasts {}, {}\n", info.at("log").get<std::string>(),
                  local_time_text(info.at("begin_s").get<double>()),
                  clock_text(info.at("seconds").get<double>()), size_text(info.at("bytes").get<double>()));
  for (const auto& [name, count] : info.at("messages").items())
    out += fmt::format("  {:>9}  {} messages\n", count.get<std::uint64_t>(), name);
  if (const std::string problem = info.at("problem").get<std::string>(); !problem.empty())
    out += fmt::format("  {}\n", problem);
  for (const Json& event : info.at("events")) {
    out += fmt::format("  {:>8}  {:<8} {}\n", clock_text(event.at("time_s").get<double>()),
                       event.at("kind").get<std::string>(), event.at("text").get<std::string>());
  }
  return out;
}

PlayKey take_key(std::string& typed) {
  struct Key {
    std::string_view sent;
    PlayKey key;
  };
  // Escape sequences must come before single letters.
  constexpr Key kKeys[] = {
      {"\x1b[A", PlayKey::kFaster}, {"\x1b[B", PlayKey::kSlower}, {"\x1b[C", PlayKey::kOn},
      {"\x1b[D", PlayKey::kBack},   {" ", PlayKey::kPause},       {".", PlayKey::kStep},
      {"+", PlayKey::kFaster},      {"-", PlayKey::kSlower},      {"g", PlayKey::kNextGoal},
      {"G", PlayKey::kLastGoal},    {"c", PlayKey::kNextCommand}, {"C", PlayKey::kLastCommand},
      {"k", PlayKey::kNextKick},    {"K", PlayKey::kLastKick},    {"q", PlayKey::kEnd},
      {"\x03", PlayKey::kEnd},  // Ctrl-C, so that the terminal's mode is restored
  };
  if (typed.empty()) return PlayKey::kNone;
  for (const Key& one : kKeys) {
    if (!typed.starts_with(one.sent)) continue;
    typed.erase(0, one.sent.size());
    return one.key;
  }
  typed.erase(0, 1);
  return PlayKey::kNone;
}

PlayKey KeyReader::next(double seconds) {
  const auto is_begun = [this] { return typed_ == "\x1b" || typed_ == "\x1b["; };
  if (typed_.empty() || is_begun()) {
    if (is_begun()) seconds = std::clamp(came_s_ + patience_s_ - steady_s(), 0.0, seconds);
    pollfd input{file_, POLLIN, 0};
    const timespec wait{static_cast<time_t>(seconds), static_cast<long>(std::fmod(seconds, 1) * 1e9)};
    if (::ppoll(&input, 1, &wait, nullptr) == 1) {
      std::array<char, 64> some{};
      const ssize_t count = ::read(file_, some.data(), some.size());
      if (count <= 0) return PlayKey::kEnd;
      typed_.append(some.data(), static_cast<std::size_t>(count));
      came_s_ = steady_s();
    }
    if (is_begun() && steady_s() < came_s_ + patience_s_) return PlayKey::kNone;
  }
  return take_key(typed_);
}

namespace {

/// Reads keys at once, without showing them. Does nothing if standard input is not a terminal.
class Keys {
 public:
  // In the background, the terminal's keys belong to another program.
  Keys()
      : is_there_(::isatty(STDIN_FILENO) == 1 && ::tcgetpgrp(STDIN_FILENO) == ::getpgrp() &&
                  ::tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (!is_there_) return;
    termios now = before_;
    now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | ISIG);
    ::tcsetattr(STDIN_FILENO, TCSANOW, &now);
  }
  ~Keys() {
    if (is_there_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  bool are_there() const { return is_there_; }

  /// Waits for a key for at most `seconds`.
  PlayKey next(double seconds) {
    if (is_there_) return reader_.next(seconds);
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    return PlayKey::kNone;
  }

 private:
  termios before_{};
  bool is_there_;
  KeyReader reader_{STDIN_FILENO};
};

/// Executes a key's command. False: stop playing.
bool obey(PlayKey key, MatchLogPlayer& player, const MatchLogPlayer::Send& send) {
  constexpr double kLeap_s = 10;
  using Kind = MatchEvent::Kind;
  switch (key) {
    case PlayKey::kNone: break;
    case PlayKey::kPause: player.pause(!player.is_paused()); break;
    case PlayKey::kStep: player.pause(true), player.step(send); break;
    case PlayKey::kBack: player.go_to(player.at_s() - kLeap_s); break;
    case PlayKey::kOn: player.go_to(player.at_s() + kLeap_s); break;
    case PlayKey::kFaster: player.set_speed(player.speed() * 2); break;
    case PlayKey::kSlower: player.set_speed(player.speed() / 2); break;
    case PlayKey::kNextGoal: player.jump(Kind::kGoal, true); break;
    case PlayKey::kLastGoal: player.jump(Kind::kGoal, false); break;
    case PlayKey::kNextCommand: player.jump(Kind::kCommand, true); break;
    case PlayKey::kLastCommand: player.jump(Kind::kCommand, false); break;
    case PlayKey::kNextKick: player.jump(Kind::kKick, true); break;
    case PlayKey::kLastKick: player.jump(Kind::kKick, false); break;
    case PlayKey::kEnd: return false;
  }
  return true;
}

}  // namespace

Played play_match_log(const std::filesystem::path& log, const PlayOptions& options) {
  constexpr double kTold_s = 0.25;
  MatchLogPlayer player(log);
  MulticastSender vision(group_of(options, options.vision_port), "--group");
  MulticastSender referee(group_of(options, options.referee_port), "--group");
  MulticastSender tracker(group_of(options, options.tracker_port), "--group");
  Played played;
  const auto send = [&](const LoggedMessage& message) {
    switch (message.type) {
      case LoggedMessage::kVision2014: vision.send(message.bytes), ++played.vision; break;
      case LoggedMessage::kReferee: referee.send(message.bytes), ++played.referee; break;
      case LoggedMessage::kTracker2020: tracker.send(message.bytes), ++played.tracked; break;
      default: ++played.others;
    }
  };
  player.set_speed(options.speed);
  player.set_longest_gap(options.longest_gap_s);
  player.go_to(options.from_s);
  Keys keys;
  if (keys.are_there())
    std::cerr << "space pause, . step, arrows 10 s and speed, g c k next goal, command, kick (G C K the one "
                 "before), q end\n";
  double told_s = 0;
  while (true) {
    const std::optional<double> due_s = player.play(steady_s(), send);
    if (options.until_s && player.at_s() >= *options.until_s) break;
    // At a terminal, a person may go back from the end.
    if (player.is_at_end() && !keys.are_there()) break;
    if (steady_s() - told_s > kTold_s) {
      told_s = steady_s();
      std::cerr << fmt::format("\r{:>8} of {}  {:g}x{}   ", clock_text(player.at_s()),
                               clock_text(player.length_s()), player.speed(),
                               player.is_at_end()   ? " end"
                               : player.is_paused() ? " paused"
                                                    : "");
    }
    if (!obey(keys.next(std::min(due_s.value_or(kTold_s), kTold_s)), player, send)) break;
  }
  played.problem = player.problem();
  return played;
}

}  // namespace sslv
