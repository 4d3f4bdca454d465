// SPDX-License-Identifier: Apache-2.0
#include "services/recording/recording_service.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "health/metrics_text.h"
#include "services/recording/recording_report.h"
#include "services/recording/recording_request.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <initializer_list>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::chrono::milliseconds kLookInterval{200};
constexpr std::chrono::seconds kCheckInterval{5};  // between checks of the disk
constexpr std::chrono::seconds kFilesInterval{1};
/// Time for which the reason is reported after a recording ended early.
constexpr double kProblemIsTold_s = 600;
constexpr const char* kEndedEarly = "its log ended early";

MatchLogGroups match_log_groups(const Config& config) {
  const NetworkSettings& network = config.network;
  const std::string& card = network.vision.interface;
  MatchLogGroups groups{.vision = {network.vision.group, network.vision.port, card},
                        .tracker = {network.tracker.group, network.tracker.port, card},
                        .referee = {}};
  if (const RefereeSettings& referee = network.referee; referee.enabled)
    groups.referee = {referee.group, referee.port, referee.interface.empty() ? card : referee.interface};
  return groups;
}

/// Calls act() immediately, then at this interval until stopped.
template <class Act>
void repeat(std::chrono::milliseconds interval, const std::stop_token& stop, Act act) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  while (!stop.stop_requested()) {
    act();
    std::unique_lock lock(mutex);
    stopped.wait_for(lock, stop, interval, [] { return false; });
  }
}

Json messages_json(std::uint64_t vision, std::uint64_t referee, std::uint64_t tracked) {
  return {{"vision", vision}, {"referee", referee}, {"tracked", tracked}};
}

Json log_json(const RecordingFile& file) {
  Json out{{"name", file.name},        {"bytes", file.bytes},    {"begin_s", nullptr},
           {"seconds", nullptr},       {"messages", nullptr},    {"goals", nullptr},
           {"pinned", file.is_pinned}, {"problem", file.problem}};
  if (!file.index) return out;
  const MatchLogIndex& index = *file.index;
  const auto count = [&](std::int32_t type) {
    const auto found = index.messages.find(type);
    return found == index.messages.end() ? 0 : found->second;
  };
  if (!index.messages.empty()) out["begin_s"] = static_cast<double>(index.first_ns) * 1e-9;
  out["seconds"] = static_cast<double>(index.last_ns - index.first_ns) * 1e-9;
  out["messages"] = messages_json(count(LoggedMessage::kVision2014), count(LoggedMessage::kReferee),
                                  count(LoggedMessage::kTracker2020));
  out["goals"] = std::ranges::count(index.events, MatchEvent::Kind::kGoal, &MatchEvent::kind);
  return out;
}

std::string name_by_teams(const std::array<std::string, 2>& teams) {
  if (teams[0].empty() || teams[1].empty()) return "by_hand";
  return fmt::format("{}-vs-{}", file_name_part(teams[0]), file_name_part(teams[1]));
}

}  // namespace

RecordingService::RecordingService(const Snapshot<Config>& config, RecordingFiles& files,
                                   const RefereeListener& referee, IsOwn is_own, TracksForLog& tracks)
    : config_(config),
      referee_(referee),
      files_(files),
      is_own_(std::move(is_own)),
      recorder_([this](std::int32_t type, const auto& sender) { return is_ours(type, sender); }, tracks),
      keeper_([this](const std::stop_token& stop) {
        // Not at idle priority: other threads wait for a lock that this thread sometimes holds.
        become_background_thread("log index", 19);
        repeat(kFilesInterval, stop, [&] { files_.look_after(stop, steady_s()); });
      }),
      thread_([this](const std::stop_token& stop) { look(stop); }) {}

bool RecordingService::is_ours(std::int32_t type, const boost::asio::ip::udp::endpoint& sender) const {
  const std::string address = sender.address().to_string();
  if (type == LoggedMessage::kReferee) return referee_.status(steady_s()).followed.address == address;
  const auto config = config_.load();
  const auto& named = config->field.other_computers;
  return std::ranges::find(named, address) != named.end() || is_own_(sender);
}

RecordingService::Recording RecordingService::recording() const {
  const std::lock_guard lock(mutex_);
  return recording_;
}

std::string RecordingService::left_out() const {
  const std::lock_guard lock(mutex_);
  return left_out_;
}

void RecordingService::leave_match_out(const std::string& why) {
  rule_.leave_match_out();
  const std::lock_guard lock(mutex_);
  left_out_ = rule_.leaves_match_out() ? why : std::string();
}

void RecordingService::set_recording(const Recording& recording) {
  const std::lock_guard lock(mutex_);
  recording_ = recording;
}

void RecordingService::look(const std::stop_token& stop) {
  become_background_thread("recordings", 15);
  double checked_s = 0;
  repeat(kLookInterval, stop, [&] {
    follow_game_controller();
    if (steady_s() - checked_s < std::chrono::duration<double>(kCheckInterval).count()) return;
    checked_s = steady_s();
    check_disk();
  });
  const std::lock_guard control(control_mutex_);
  end();
}

void RecordingService::follow_game_controller() {
  recorder_.listen(match_log_groups(*config_.load()));
  const std::lock_guard control(control_mutex_);
  const Recording now = recording();
  const MatchRule::Wish wish = rule_.look(referee_.status(steady_s()));
  if (!rule_.leaves_match_out()) {
    const std::lock_guard lock(mutex_);
    left_out_.clear();
  }
  if (now.started_by != StartedBy::kNobody) {
    if (const auto status = recorder_.status(); !status.is_recording) return end(status.problem);
  }
  if (now.started_by == StartedBy::kHand) return;
  const bool follows =
      config_.load()->recording.match_logs == RecordingSettings::MatchLogs::kByGameController;
  const bool is_recording = now.started_by != StartedBy::kNobody;
  if (!now.problem.empty() && unix_time_s() - now.problem_s > kProblemIsTold_s) set_recording({});
  if (!follows || wish == MatchRule::Wish::kNone) {
    if (is_recording) end();
    return;
  }
  if (is_recording && now.match != rule_.number()) end();  // another match has begun
  if (recording().started_by == StartedBy::kNobody) {
    if (wish == MatchRule::Wish::kPause) return;
    try {
      begin(StartedBy::kGameController, rule_.name());
    } catch (const StorageError& error) {
      log::error("{}; the match is not recorded", error.what());
      leave_match_out(kEndedEarly);  // otherwise it would retry five times a second
      return set_recording({.problem = error.what(), .problem_s = unix_time_s()});
    }
  }
  const bool is_paused = wish == MatchRule::Wish::kPause;
  recorder_.pause(is_paused);
  Recording after = recording();
  after.is_paused = is_paused;
  set_recording(after);
}

void RecordingService::check_disk() {
  const std::lock_guard control(control_mutex_);
  std::string problem, quota_problem;
  if (const Recording now = recording(); now.started_by != StartedBy::kNobody)
    files_.count(now.name(), recorder_.status().counted_share());
  try {
    Room room = files_.make_room(config_.load()->recording, RoomFor::kMatchLog, events_);
    recorder_.cut_strangers(room.is_scarce);
    quota_problem = std::move(room.problem);
  } catch (const StorageError& error) {
    problem = error.what();
    if (recording().started_by != StartedBy::kNobody) {
      log::error("the match log ends: {}", problem);
      leave_match_out(kEndedEarly);
      end(problem);
    }
  }
  const std::lock_guard lock(mutex_);
  no_room_problem_ = std::move(problem);
  quota_problem_ = std::move(quota_problem);
}

void RecordingService::begin(StartedBy by, const std::string& name) {
  files_.make_room(config_.load()->recording, RoomFor::kMatchLog, events_);
  const std::filesystem::path file = files_.begin(name);
  try {
    recorder_.begin(file);
  } catch (const StorageError&) {
    files_.end(file, false);
    throw;
  }
  const std::string file_name = file.filename().string();
  log::info("match log {} begins", file_name);
  events_.add({.id = "recording_started", .title = fmt::format("Match log {} began", file_name)});
  set_recording({.started_by = by, .match = rule_.number(), .file = file, .begin_s = unix_time_s()});
}

void RecordingService::end(const std::string& problem) {
  const Recording before = recording();
  if (before.started_by == StartedBy::kNobody) return;
  recorder_.end();
  const MatchLogRecorder::Status status = recorder_.status();
  try {
    files_.end(before.file, status.problem.empty());
  } catch (const StorageError& error) {
    log::warning("{}", error.what());  // the log is complete; look_after() removes the mark
  }
  log::info("match log {} ends: {} messages, {} bytes, {} lost, {} refused, {} dropped for lack of space",
            before.name(), status.vision + status.referee + status.tracked, status.bytes, status.lost,
            status.refused, status.cut);
  events_.add({.id = "recording_ended", .title = fmt::format("Match log {} ended", before.name())});
  const std::string& why = problem.empty() ? status.problem : problem;
  if (!why.empty()) leave_match_out(kEndedEarly);
  set_recording({.problem = why, .problem_s = unix_time_s()});
}

std::vector<Route> RecordingService::routes() {
  constexpr const char* kLog = "/api/recordings/logs/([^/]+)";
  Route download{"GET", kLog, [this](const Request& request) { return get_log(request); }};
  download.streams = true;
  return {{"GET", "/api/recordings", [this](const Request&) { return json_response(to_json()); }},
          // Allowed while a match locks the settings, because users want recordings during matches.
          {"POST", "/api/recordings/match-log",
           [this](const Request& request) { return put_match_log(request); }, Needs::kChange},
          {"GET", "/api/recordings/logs/([^/]+)/events",
           [this](const Request& request) { return get_events(request); }},
          download,
          {"PATCH", kLog, [this](const Request& request) { return change_log(request); }, Needs::kChange},
          {"DELETE", kLog, [this](const Request& request) { return remove_log(request); }, Needs::kChange}};
}

Json RecordingService::to_json() const {
  const Recording now = recording();
  const DiskUse disk = files_.disk_use();
  const auto config = config_.load();
  const MatchLogRecorder::Status status = recorder_.status();
  const bool is_recording = now.started_by != StartedBy::kNobody;
  const bool by_hand = config->recording.match_logs == RecordingSettings::MatchLogs::kByHand;
  const std::string left_out = by_hand ? std::string() : this->left_out();
  std::string no_room;
  {
    const std::lock_guard lock(mutex_);
    no_room = no_room_problem_;
  }
  const char* state = !now.problem.empty() ? "failed"
                      : by_hand            ? "off"
                      : left_out.empty()   ? "waiting"
                                           : "left_out";
  if (is_recording) state = now.is_paused ? "paused" : "recording";
  Json logs = Json::array();
  for (const RecordingFile& file : files_.list(RecordingFile::Kind::kMatchLog))
    logs.push_back(log_json(file));
  return {
      {"match_log",
       {{"state", state},
        {"name", is_recording ? Json(now.name()) : Json(nullptr)},
        {"started_by", is_recording ? Json(now.started_by == StartedBy::kHand ? "hand" : "game_controller")
                                    : Json(nullptr)},
        {"begin_s", is_recording ? Json(now.begin_s) : Json(nullptr)},
        {"seconds", is_recording ? std::max(0.0, unix_time_s() - now.begin_s) : 0.0},
        {"bytes", is_recording ? status.bytes : 0},
        {"messages", is_recording ? messages_json(status.vision, status.referee, status.tracked)
                                  : messages_json(0, 0, 0)},
        {"lost", is_recording ? status.lost : 0},
        {"refused", is_recording ? status.refused + status.cut : 0},
        {"error", is_recording || !now.problem.empty() ? now.problem
                  : !left_out.empty()                  ? left_out
                                                       : no_room}}},
      {"disk",
       {{"used_bytes", disk.used_bytes},
        {"quota_bytes", static_cast<std::uint64_t>(config->recording.quota_mb) * kMb},
        {"free_bytes", disk.free_bytes}}},
      {"logs", std::move(logs)}};
}

Response RecordingService::put_match_log(const Request& request) {
  const Json body = body_json(request);
  check_keys(body, {"record", "name"});
  if (!body.contains("record") || !body["record"].is_boolean())
    throw HttpError(400, "/record: expected true or false");
  const std::string name = body.contains("name") ? asked_name(body) : name_by_teams(referee_.team_names());
  const std::lock_guard control(control_mutex_);
  const bool is_recording = recording().started_by != StartedBy::kNobody;
  if (body["record"].get<bool>()) {
    if (is_recording) throw HttpError(409, "a match log is being recorded already");
    begin(StartedBy::kHand, name);
  } else {
    if (!is_recording) throw HttpError(409, "no match log is being recorded");
    // Ending a log that was started by hand does not affect the match, which may have begun meanwhile.
    if (recording().started_by == StartedBy::kGameController)
      leave_match_out(fmt::format("{} stopped its log", request.address));
    end();
  }
  return json_response(to_json());
}

RecordingFile RecordingService::find(const Request& request) const {
  auto file = files_.find(request.matches.at(1));
  if (!file || file->kind != RecordingFile::Kind::kMatchLog)
    throw HttpError(404, "there is no such recording");
  return *std::move(file);
}

Response RecordingService::change_log(const Request& request) {
  const RecordingFile file = find(request);
  files_.pin(file.name, asked_pinned(request));
  return json_response(to_json());
}

Response RecordingService::remove_log(const Request& request) {
  const RecordingFile file = find(request);
  if (!files_.remove(file.name)) throw HttpError(409, "it is being recorded; stop that first");
  return json_response(to_json());
}

Response RecordingService::get_log(const Request& request) const {
  const RecordingFile file = find(request);
  return file_response(files_.path_of(file.name),
                       file.name.ends_with(".gz") ? "application/gzip" : "application/octet-stream",
                       file.name);
}

Response RecordingService::get_events(const Request& request) const {
  const RecordingFile file = find(request);
  if (!file.index && !file.problem.empty()) throw HttpError(422, file.problem);
  if (!file.index) throw HttpError(409, "it is still being read or recorded; try again in a moment");
  const MatchLogIndex& index = *file.index;
  Json events = Json::array();
  for (const MatchEvent& event : index.events) {
    events.push_back({{"time_s", static_cast<double>(event.time_ns - index.first_ns) * 1e-9},
                      {"kind", name_of(event.kind)},
                      {"text", event.text}});
  }
  return json_response({{"begin_s", static_cast<double>(index.first_ns) * 1e-9},
                        {"end_s", static_cast<double>(index.last_ns) * 1e-9},
                        {"events", std::move(events)}});
}

void RecordingService::report(HealthReport& report) const {
  RecordingFacts facts;
  {
    const std::lock_guard lock(mutex_);
    facts.is_recording = recording_.started_by != StartedBy::kNobody;
    facts.is_paused = recording_.is_paused;
    facts.problem = recording_.problem;
    facts.no_room_problem = no_room_problem_;
    facts.quota_problem = quota_problem_;
    facts.left_out = left_out_;
  }
  facts.is_by_hand = config_.load()->recording.match_logs == RecordingSettings::MatchLogs::kByHand;
  if (facts.is_recording) {
    const MatchLogRecorder::Status status = recorder_.status();
    facts.bytes = status.bytes;
    facts.lost = status.lost;
    facts.refused = status.refused;
    facts.cut = status.cut;
  }
  report_recording(facts, report);
}

void RecordingService::write_metrics(MetricsText& out) const {
  out.begin("sslv_match_log_recording", "gauge", "1 while a match log is recorded.");
  out.add({}, std::uint64_t{recording().started_by == StartedBy::kNobody ? 0U : 1U});
  out.begin("sslv_match_log_lost_messages", "gauge", "Messages that the match log lacks.");
  out.add({}, recorder_.status().lost);
  out.begin(
      "sslv_match_log_refused_messages", "gauge",
      "Datagrams that the match log drops: not the league's, more than a field sends, or strangers' when "
      "space is low.");
  out.add({}, recorder_.status().refused + recorder_.status().cut);
}

}  // namespace sslv
