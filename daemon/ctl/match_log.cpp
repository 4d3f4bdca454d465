// SPDX-License-Identifier: Apache-2.0
#include "ctl/match_log.h"

#include "ctl/table.h"
#include "net/multicast.h"
#include "recording/match_log_reader.h"

#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>

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

/// "1:02:03", or "2:03".
std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(std::max(0.0, seconds));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string size_text(double bytes) {
  return fmt::format("{:.1f} MB", bytes * 1e-6);
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

std::string recordings_text(const Json& recordings) {
  const Json& now = recordings.at("match_log");
  const std::string state = now.at("state").get<std::string>();
  std::string out = fmt::format("match log: {}", state);
  if (!now.at("name").is_null())
    out += fmt::format(" {}, {}, {}", now.at("name").get<std::string>(),
                       clock_text(now.at("seconds").get<double>()), size_text(now.at("bytes").get<double>()));
  if (const std::string error = now.at("error").get<std::string>(); !error.empty())
    out += fmt::format(": {}", error);
  const Json& disk = recordings.at("disk");
  out += fmt::format("\ndisk: {} of {} used, {} free\n", size_text(disk.at("used_bytes").get<double>()),
                     size_text(disk.at("quota_bytes").get<double>()),
                     size_text(disk.at("free_bytes").get<double>()));
  std::vector<std::vector<std::string>> rows;
  for (const Json& log : recordings.at("logs")) {
    rows.push_back({log.at("name").get<std::string>(),
                    log.at("seconds").is_null() ? "" : clock_text(log.at("seconds").get<double>()),
                    size_text(log.at("bytes").get<double>()), log.at("pinned").get<bool>() ? "pinned" : "",
                    log.at("problem").get<std::string>()});
  }
  if (!rows.empty()) out += "\n" + table_text({{"log"}, {"length", true}, {"size", true}, {""}, {""}}, rows);
  return out;
}

Played play_match_log(const std::filesystem::path& log, const PlayOptions& options,
                      const std::function<void(double)>& tell) {
  using Clock = std::chrono::steady_clock;
  const MatchLogIndex index = match_log_index(log);
  MatchLogReader reader(log);
  MulticastSender vision(group_of(options, options.vision_port), "--group");
  MulticastSender referee(group_of(options, options.referee_port), "--group");
  MulticastSender tracker(group_of(options, options.tracker_port), "--group");
  const auto ns = [](double seconds) { return static_cast<std::int64_t>(seconds / kNs); };
  reader.go_to(index.first_ns + ns(options.from_s), index);

  Played played;
  Clock::time_point due = Clock::now(), told{};
  std::optional<std::int64_t> before_ns;
  for (LoggedMessage message; reader.next(message); before_ns = message.time_ns) {
    const double at_s = static_cast<double>(message.time_ns - index.first_ns) * kNs;
    if (options.until_s && at_s > *options.until_s) return played;
    double gap_s = before_ns ? std::max(0.0, static_cast<double>(message.time_ns - *before_ns) * kNs) : 0;
    if (options.longest_gap_s > 0) gap_s = std::min(gap_s, options.longest_gap_s);
    due += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(gap_s / options.speed));
    std::this_thread::sleep_until(due);
    if (due - told >= std::chrono::seconds(1)) {
      told = due;
      tell(at_s);
    }
    switch (message.type) {
      case LoggedMessage::kVision2014: vision.send(message.bytes), ++played.vision; break;
      case LoggedMessage::kReferee: referee.send(message.bytes), ++played.referee; break;
      case LoggedMessage::kTracker2020: tracker.send(message.bytes), ++played.tracked; break;
      default: ++played.others;
    }
  }
  played.problem = reader.problem();
  return played;
}

}  // namespace sslv
