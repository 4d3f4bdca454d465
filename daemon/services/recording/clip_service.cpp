// SPDX-License-Identifier: Apache-2.0
#include "services/recording/clip_service.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "clips/clip_reader.h"
#include "health/metrics_text.h"
#include "recording/match_events.h"
#include "services/recording/match_rule.h"
#include "services/recording/recording_report.h"
#include "services/recording/recording_request.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::chrono::milliseconds kOrderInterval{200};
constexpr double kShareInterval_s = 1;
/// A clip starts this much earlier than requested, because it must begin with a keyframe (a frame with the
/// saved state of the stages). RecordedCamera records keyframes at shorter intervals than this.
constexpr double kKeyInterval_s = 0.3;
constexpr double kKeptEvents_s = 1300;
constexpr std::size_t kMaxEvents = 1000, kMaxEventBytes = 400;  // together less than a clip can hold
constexpr double kFailureIsTold_s = 600;
/// Minimum time between crash clips.
constexpr std::chrono::seconds kCrashClipInterval{60};
constexpr std::size_t kMaxCrashClips = 3;  // not counting pinned clips
/// Minimum time between two clips for alerts of one kind.
constexpr double kAlertAgain_s = 60;

Json clip_json(const RecordingFile& file) {
  Json out{
      {"name", file.name}, {"bytes", file.bytes},      {"begin_s", nullptr},       {"seconds", nullptr},
      {"why", ""},         {"cameras", Json::array()}, {"pinned", file.is_pinned}, {"problem", file.problem}};
  if (!file.clip) return out;
  out["begin_s"] = file.clip->begin_s;
  out["seconds"] = file.clip->end_s - file.clip->begin_s;
  out["why"] = file.clip->why;
  for (const ClipFacts::Camera& camera : file.clip->cameras)
    out["cameras"].push_back({{"id", camera.id}, {"frames", camera.frames}, {"missing", camera.missing}});
  return out;
}

}  // namespace

ClipService::ClipService(const Snapshot<Config>& config, RecordingFiles& files, Cameras& cameras,
                         const RefereeListener& referee, std::vector<KeptFile> left)
    : config_(config),
      files_(files),
      referee_(referee),
      last_seconds_(cameras),
      maker_(config, files, events_),
      is_writing_(!left.empty()),
      left_(std::move(left)),
      thread_([this](const std::stop_token& stop) {
        become_background_thread("clips");
        work(stop);
      }) {}

void ClipService::work(const std::stop_token& stop) {
  // First write the clip of the crashed run, which also frees that run's memory: the new ring buffers would
  // otherwise double the memory in use.
  if (!left_.empty()) write_left(std::move(left_), stop);
  double shared_s = 0;
  while (!stop.stop_requested()) {
    const auto order = next_order(stop);
    look_at_game();
    if (order) {
      write(*order, stop);
    } else if (steady_s() - shared_s >= kShareInterval_s) {
      shared_s = steady_s();
      last_seconds_.look(config_.load()->recording, steady_s(), stop);
    }
  }
}

std::optional<ClipOrder> ClipService::next_order(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  ordered_.wait_for(lock, stop, kOrderInterval, [&] { return order_.has_value(); });
  if (!order_) return std::nullopt;
  is_writing_ = true;
  return std::exchange(order_, std::nullopt);
}

bool ClipService::put(ClipOrder order) {
  {
    const std::lock_guard lock(mutex_);
    if (order_ || is_writing_) return false;
    order_ = std::move(order);
  }
  ordered_.notify_one();
  return true;
}

void ClipService::note_event(const std::string& kind, const std::string& text) {
  const std::lock_guard lock(mutex_);
  recent_.push_back({unix_time_s(), kind, shortened(text, kMaxEventBytes)});
  while (recent_.size() > kMaxEvents || recent_.front().time_s < unix_time_s() - kKeptEvents_s)
    recent_.pop_front();
}

void ClipService::order_for_event(bool is_wanted, const std::string& kind, const std::string& text) {
  note_event(kind, text);
  if (!is_wanted) return;
  const ClipSettings settings = config_.load()->recording.clips;
  const double now_s = steady_s();
  // Ignore the result: if another clip is being written, that clip lists this event.
  put({.name = kind,
       .kind = kind,
       .why = text,
       .begin_s = now_s - settings.seconds,
       .end_s = now_s + settings.seconds_after});
}

void ClipService::see_alerts(const std::vector<Alert>& alerts) {
  const ClipSettings settings = config_.load()->recording.clips;
  std::set<std::string> now;
  std::vector<std::pair<const Alert*, bool>> added;  // alert, and whether a clip may be made for it
  {
    const std::lock_guard lock(mutex_);
    for (const Alert& alert : alerts) {
      const std::string key = fmt::format("{} {} {}", alert.id, alert.camera.value_or(-1), alert.about);
      now.insert(key);
      // Alerts about clips and crashes cause no clips.
      if (alerts_.contains(key) || alert.id.starts_with("clip_") || alert.id == "service_crashed") continue;
      double& made_s = clipped_.emplace(alert.id, -1e9).first->second;
      const bool may = steady_s() - made_s >= kAlertAgain_s;
      if (may) made_s = steady_s();
      if (alert.severity != Severity::kInfo) trouble_ = {unix_time_s(), "alert", alert.title};
      added.emplace_back(&alert, may);
    }
    alerts_ = std::move(now);
  }
  for (const auto& [alert, may] : added) order_for_event(settings.on_alert && may, "alert", alert->title);
}

void ClipService::look_at_game() {
  const ClipSettings settings = config_.load()->recording.clips;
  const auto now = referee_.status(steady_s()).match;
  const auto before = std::exchange(match_, now);
  if (!now || !before) return;
  for (std::size_t team = 0; team < 2; ++team) {
    if (now->score[team] > before->score[team]) {
      order_for_event(
          settings.on_goal, "goal",
          fmt::format("Goal for {}: {} : {}", team == 0 ? "yellow" : "blue", now->score[0], now->score[1]));
    }
  }
  if (now->command && now->command != before->command)
    order_for_event(settings.on_command, "command", command_text(*now->command));
}

/// Writes a clip from the memory of the crashed run, and sets crash_.
void ClipService::write_left(std::vector<KeptFile> files, const std::stop_token& stop) {
  std::string told;
  {
    const LastSeconds::Left left = LastSeconds::crash_rings(std::move(files));
    if (!left.rings.empty()) {
      told = "The service crashed and was restarted";
      if (config_.load()->recording.clips.on_crash) told += write_crash_clip(left, stop);
    } else if (left.was_read) {
      told =
          "The service crashed again while it wrote a clip of a crash, and was restarted; there is no clip "
          "of it";
    }
  }
  if (!told.empty()) log::warning("{}", told);
  const std::lock_guard lock(mutex_);
  is_writing_ = false;
  crash_ = std::move(told);
  crash_s_ = steady_s();
}

/// Returns the clips of crashes, last written first. Reads the kind from the file, because users may give
/// clips any name.
std::vector<RecordingFile> ClipService::crash_clips(const std::stop_token& stop) const {
  std::vector<RecordingFile> out = files_.list(RecordingFile::Kind::kClip);
  std::erase_if(out, [&](const RecordingFile& file) {
    try {
      return ClipReader(files_.path_of(file.name), stop).about().kind != kCrashClip;
    } catch (const ClipError&) {
      return true;
    }
  });
  return out;
}

/// Returns the outcome as the second half of a sentence.
std::string ClipService::write_crash_clip(const LastSeconds::Left& left, const std::stop_token& stop) {
  // A service that crashes repeatedly must neither spend all its time on clips nor fill the disk.
  std::size_t kept = 0;
  for (const RecordingFile& file : crash_clips(stop)) {
    std::error_code error;
    const auto written = std::filesystem::last_write_time(files_.path_of(file.name), error);
    const auto age = std::filesystem::file_time_type::clock::now() - written;
    if (!error && age >= age.zero() && age < kCrashClipInterval)
      return "; a clip of a crash was made less than a minute ago";
    if (file.is_pinned || ++kept < kMaxCrashClips) continue;
    try {
      if (files_.remove(file.name))
        log::info("recording {} was removed: it is from an earlier crash", file.name);
    } catch (const StorageError& problem) {
      log::warning("{}", problem.what());  // more disk use is better than no new clip
    }
  }
  ClipOrder order{.name = std::string(kCrashClip),
                  .kind = std::string(kCrashClip),
                  .why = "the service crashed",
                  .begin_s = steady_s(),
                  .end_s = 0,
                  .can_wait = true};
  constexpr double kRounding_s = 1e-3;
  for (const LastSeconds::Ring& ring : left.rings) {
    const ImageRing::Extent extent = ring.ring->extent();
    order.begin_s = std::min(order.begin_s, static_cast<double>(extent.oldest_ns) * 1e-9 - kRounding_s);
    order.end_s = std::max(order.end_s, static_cast<double>(extent.newest_ns) * 1e-9 + kRounding_s);
  }
  const auto tell = [this](const ClipProgress& progress) {
    const std::lock_guard lock(mutex_);
    clip_ = progress;
  };
  const auto happened = [](double newest_s) {
    return std::vector<ClipEvent>{{newest_s, "alert", "The service crashed"}};
  };
  const int every_nth = config_.load()->recording.last_seconds.kept_every();
  const ClipProgress clip =
      maker_.make(order, left.rings, every_nth, {.tell = tell, .wait = {}, .happened = happened}, stop);
  if (clip.problem.empty()) return fmt::format("; clip {} shows what the cameras saw before", clip.file);
  {
    const std::lock_guard lock(mutex_);
    clip_ = {};  // its file may have been removed
  }
  if (stop.stop_requested()) {
    for (const LastSeconds::Ring& ring : left.rings) ring.ring->put_back();
  } else if (clip.frames > 0) {
    return fmt::format("; clip {} is incomplete: {}", clip.file, clip.problem);
  }
  return fmt::format("; there is no clip of it: {}", clip.problem);
}

void ClipService::write(const ClipOrder& order, const std::stop_token& stop) {
  const auto tell = [this](const ClipProgress& progress) {
    const std::lock_guard lock(mutex_);
    clip_ = progress;
  };
  ClipOrder from_key = order;
  from_key.begin_s -= kKeyInterval_s;
  ClipProgress clip =
      maker_.make(from_key, last_seconds_.rings(), last_seconds_.status().settings.kept_every(),
                  {.tell = tell,
                   .wait = [this] { look_at_game(); },
                   .happened = [&](double) { return happened_in(order); }},
                  stop);
  const std::lock_guard lock(mutex_);
  is_writing_ = false;
  if (clip.problem.empty()) return;
  log::error("the clip is not written: {}", clip.problem);
  clip_ = {.problem = std::move(clip.problem)};
  problem_s_ = steady_s();
}

std::vector<ClipEvent> ClipService::happened_in(const ClipOrder& order) const {
  std::vector<ClipEvent> out;
  const double ahead_s = unix_time_s() - steady_s();  // offset from steady to Unix time
  const std::lock_guard lock(mutex_);
  for (const ClipEvent& event : recent_) {
    if (event.time_s >= order.begin_s + ahead_s - 1 && event.time_s <= order.end_s + ahead_s + 1)
      out.push_back(event);
  }
  return out;
}

std::vector<Route> ClipService::routes() {
  constexpr const char* kClip = "/api/recordings/clips/([^/]+)";
  Route download{"GET", kClip, [this](const Request& request) { return get_clip(request); }};
  download.streams = true;
  return {{"GET", "/api/recordings/clips", [this](const Request&) { return json_response(to_json()); }},
          // Allowed while a match locks the settings, because users want clips during matches.
          {"POST", "/api/recordings/clips", [this](const Request& request) { return make_clip(request); },
           Needs::kChange},
          download,
          {"PATCH", kClip, [this](const Request& request) { return change_clip(request); }, Needs::kChange},
          {"DELETE", kClip, [this](const Request& request) { return remove_clip(request); }, Needs::kChange}};
}

Json ClipService::to_json() const {
  const LastSeconds::Status status = last_seconds_.status();
  Json cameras = Json::array();
  for (const LastSeconds::CameraStatus& camera : status.cameras) {
    cameras.push_back({{"id", camera.id},
                       {"seconds", camera.seconds},
                       {"frames", camera.frames},
                       {"bytes", camera.bytes},
                       {"dropped", camera.dropped}});
  }
  Json clips = Json::array();
  for (const RecordingFile& file : files_.list(RecordingFile::Kind::kClip)) clips.push_back(clip_json(file));
  const ClipSettings settings = config_.load()->recording.clips;
  const std::lock_guard lock(mutex_);
  const bool is_busy = is_writing_ || order_;
  return {{"last_seconds",
           {{"memory_bytes", status.bytes},
            {"wanted_bytes", status.wanted_bytes},
            {"images", params_to_json(status.settings).at("images")},
            {"every_nth", status.settings.every_nth},
            {"cameras", std::move(cameras)},
            {"problem", status.problem}}},
          {"clip",
           {{"state", is_busy                 ? "writing"
                      : clip_.problem.empty() ? "idle"
                                              : "failed"},
            {"name", clip_.file},
            {"why", clip_.why},
            {"frames", clip_.frames},
            {"missing", clip_.missing},
            {"bytes", clip_.bytes},
            {"error", is_busy ? "" : clip_.problem}}},
          {"seconds", settings.seconds},
          {"clips", std::move(clips)}};
}

/// What happened in the last `seconds`: a goal, else an alert, else a command, always the newest; empty:
/// nothing.
std::string ClipService::last_event(double seconds) const {
  const double since_s = unix_time_s() - seconds;
  const std::lock_guard lock(mutex_);
  const auto newest = [&](const char* kind) {
    const auto found = std::find_if(recent_.rbegin(), recent_.rend(), [&](const ClipEvent& event) {
      return event.time_s >= since_s && event.kind == kind;
    });
    return found == recent_.rend() ? std::string() : found->text;
  };
  if (std::string goal = newest("goal"); !goal.empty()) return goal;
  return trouble_.time_s >= since_s ? trouble_.text : newest("command");
}

Response ClipService::make_clip(const Request& request) {
  const Json body = request.body.empty() ? Json::object() : body_json(request);
  check_keys(body, {"seconds", "seconds_after", "name"});
  const ClipSettings settings = config_.load()->recording.clips;
  const auto number = [&](const char* key, double least, double otherwise) {
    if (!body.contains(key)) return otherwise;
    constexpr double kMax_s = 600;
    const bool is_good =
        body[key].is_number() && body[key].get<double>() >= least && body[key].get<double>() <= kMax_s;
    if (!is_good)
      throw HttpError(400, fmt::format("/{}: expected a number of seconds, {} to {}", key, least, kMax_s));
    return body[key].get<double>();
  };
  const double before_s = number("seconds", 0.5, settings.seconds), after_s = number("seconds_after", 0, 0);
  // Without a name, what happened in this time gives one.
  const std::string event = last_event(before_s);
  const std::string name = body.contains("name") ? asked_name(body)
                           : event.empty()       ? "by_hand"
                                                 : file_name_part(event);
  const LastSeconds::Status status = last_seconds_.status();
  if (status.bytes == 0) {
    throw HttpError(409, status.is_off()
                             ? "no images are kept in memory: /recording/last_seconds/memory_mb is 0"
                             : "no images are in memory yet; try again in a few seconds");
  }
  const double now_s = steady_s();
  if (!put({.name = name,
            .kind = std::string(kKeptClip),
            .why = event.empty() ? "kept by hand" : "kept by hand after: " + event,
            .who = request.address,
            .begin_s = now_s - before_s,
            .end_s = now_s + after_s}))
    throw HttpError(409, "a clip is being written; try again when it is done");
  return json_response(to_json(), 202);
}

RecordingFile ClipService::find(const Request& request) const {
  auto file = files_.find(request.matches.at(1));
  if (!file || file->kind != RecordingFile::Kind::kClip) throw HttpError(404, "there is no such clip");
  return *std::move(file);
}

Response ClipService::change_clip(const Request& request) {
  const RecordingFile file = find(request);
  files_.pin(file.name, asked_pinned(request));
  return json_response(to_json());
}

Response ClipService::remove_clip(const Request& request) {
  const RecordingFile file = find(request);
  if (!files_.remove(file.name)) throw HttpError(409, "it is being written; wait until it is done");
  return json_response(to_json());
}

Response ClipService::get_clip(const Request& request) const {
  const RecordingFile file = find(request);
  return file_response(files_.path_of(file.name), "application/octet-stream", file.name);
}

std::optional<SupportRecording> ClipService::support_clip(const std::string& name) const {
  const auto file = files_.find(name);
  if (!file || file->kind != RecordingFile::Kind::kClip) return std::nullopt;
  if (file->is_open) throw HttpError(409, "clip: it is being written; wait until it is done");
  return SupportRecording{files_.path_of(name),
                          "the cameras' images and what was found in them. It shows the people on and around "
                          "the field: share it only if they agree"};
}

void ClipService::report(HealthReport& report) const {
  const LastSeconds::Status status = last_seconds_.status();
  LastSecondsFacts facts{
      .is_wanted = !status.is_off(), .is_there = status.bytes > 0, .problem = status.problem};
  double least_s = std::numeric_limits<double>::max();
  for (const LastSeconds::CameraStatus& camera : status.cameras) {
    if (camera.bytes > 0) least_s = std::min(least_s, camera.seconds);
  }
  if (facts.is_there) facts.seconds = least_s;
  {
    const std::lock_guard lock(mutex_);
    if (steady_s() - problem_s_ < kFailureIsTold_s) facts.clip_problem = clip_.problem;
    if (steady_s() - crash_s_ < kFailureIsTold_s) facts.crash = crash_;
  }
  report_last_seconds(facts, report);
}

void ClipService::write_metrics(MetricsText& out) const {
  const LastSeconds::Status status = last_seconds_.status();
  out.begin("sslv_last_seconds", "gauge", "Seconds of each camera's images that are in memory.");
  for (const LastSeconds::CameraStatus& camera : status.cameras)
    out.add({{"camera", std::to_string(camera.id)}}, camera.seconds);
  out.begin("sslv_last_seconds_dropped_frames", "gauge",
            "Frames that are not in memory because a clip was being written.");
  for (const LastSeconds::CameraStatus& camera : status.cameras)
    out.add({{"camera", std::to_string(camera.id)}}, camera.dropped);
}

}  // namespace sslv
