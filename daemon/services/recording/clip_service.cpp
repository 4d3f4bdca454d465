// SPDX-License-Identifier: Apache-2.0
#include "services/recording/clip_service.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/log.h"
#include "config/version.h"
#include "health/metrics_text.h"
#include "recording/match_events.h"
#include "replay/clip_setup.h"
#include "services/recording/recording_report.h"
#include "services/recording/recording_request.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::chrono::milliseconds kOrderInterval{200}, kNextFrames{20};
constexpr double kShareInterval_s = 1;
/// Stages' memory is kept so often, and with it a whole image where others are kept in parts; a clip begins
/// where it is.
constexpr double kKeyInterval_s = 0.3, kWholeInterval_s = 1.1;
/// For frames that are still on their way when the clip ends.
constexpr double kLateFrames_s = 0.3;
constexpr double kKeptEvents_s = 1300;
constexpr std::size_t kMaxEvents = 1000;
constexpr double kFailureIsTold_s = 600;
/// Part of the names of clips of crashes, and how far they are apart.
constexpr const char* kCrashName = "crash";
constexpr std::chrono::seconds kCrashClipInterval{60};
constexpr std::size_t kMostCrashClips = 3;  // besides those that are pinned
/// Between two clips for alerts of one kind.
constexpr double kAlertAgain_s = 60;
constexpr std::uint64_t kCheckDiskEvery = 64'000'000;  // bytes
/// A match log must never end because a clip took the last of the room.
constexpr int kReserve_mb = 200;

/// Nothing is held back from match logs where they have little room anyway.
RecordingSettings with_reserve(RecordingSettings settings) {
  const int reserve_mb = std::min(kReserve_mb, settings.quota_mb / 4);
  settings.quota_mb -= reserve_mb;
  settings.keep_free_mb += reserve_mb;
  return settings;
}

int every_nth_of(const LastSecondsSettings& settings) {
  return settings.images == LastSecondsSettings::Images::kEveryNth ? settings.every_nth : 1;
}

std::int64_t to_ns(double steady_s) {
  return std::llround(steady_s * 1e9);
}

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
      is_writing_(!left.empty()),
      left_(std::move(left)),
      thread_([this](const std::stop_token& stop) {
        become_background_thread("clips");
        work(stop);
      }) {}

void ClipService::work(const std::stop_token& stop) {
  // First: together with the new last seconds it would be twice the memory.
  if (!left_.empty()) write_left(std::move(left_), stop);
  double shared_s = 0;
  while (!stop.stop_requested()) {
    const auto order = next_order(stop);
    look_at_game();
    if (order) {
      write(*order, stop);
    } else if (steady_s() - shared_s >= kShareInterval_s) {
      shared_s = steady_s();
      last_seconds_.look(config_.load()->recording.last_seconds, steady_s(), stop);
    }
  }
}

std::optional<ClipService::Order> ClipService::next_order(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  ordered_.wait_for(lock, stop, kOrderInterval, [&] { return order_.has_value(); });
  if (!order_) return std::nullopt;
  is_writing_ = true;
  return std::exchange(order_, std::nullopt);
}

bool ClipService::put(Order order) {
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
  recent_.push_back({unix_time_s(), kind, text});
  while (recent_.size() > kMaxEvents || recent_.front().time_s < unix_time_s() - kKeptEvents_s)
    recent_.pop_front();
}

void ClipService::order_for_event(bool is_wanted, const std::string& kind, const std::string& text) {
  note_event(kind, text);
  if (!is_wanted) return;
  const ClipSettings settings = config_.load()->recording.clips;
  const double now_s = steady_s();
  // What happens while one is written stands in that one's list of events.
  put({.name = kind,
       .why = text,
       .begin_s = now_s - settings.seconds,
       .end_s = now_s + settings.seconds_after});
}

void ClipService::see_alerts(const std::vector<Alert>& alerts) {
  const ClipSettings settings = config_.load()->recording.clips;
  std::set<std::string> now;
  std::vector<std::pair<const Alert*, bool>> added;  // and whether a clip may be made for it
  {
    const std::lock_guard lock(mutex_);
    for (const Alert& alert : alerts) {
      const std::string key = fmt::format("{} {} {}", alert.id, alert.camera.value_or(-1), alert.about);
      now.insert(key);
      // Those of clips and of a crash tell of clips themselves.
      if (alerts_.contains(key) || alert.id.starts_with("clip_") || alert.id == "service_crashed") continue;
      double& made_s = clipped_.emplace(alert.id, -1e9).first->second;
      const bool may = steady_s() - made_s >= kAlertAgain_s;
      if (may) made_s = steady_s();
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

/// What the cameras saw before the service crashed.
void ClipService::write_left(std::vector<KeptFile> files, const std::stop_token& stop) {
  LeftRings left(std::move(files));
  std::string told;
  if (left.extent().frames > 0) {
    told = "The service crashed and runs again";
    if (config_.load()->recording.clips.on_crash) {
      told += had_crash_clip() ? "; a clip of a crash was made less than a minute ago"
                               : write_crash_clip(left, stop);
    }
  } else if (left.was_read()) {
    told =
        "The service crashed again while it wrote a clip of a crash, and runs again; there is no clip of it";
  }
  if (!told.empty()) log::warning("{}", told);
  const std::lock_guard lock(mutex_);
  is_writing_ = false;
  crash_ = std::move(told);
  crash_s_ = steady_s();
}

/// Those that were written last come first.
std::vector<RecordingFile> ClipService::crash_clips() const {
  std::vector<RecordingFile> out = files_.list(RecordingFile::Kind::kClip);
  std::erase_if(out, [](const RecordingFile& file) {
    return file.name.find(fmt::format("_{}.", kCrashName)) == std::string::npos &&
           file.name.find(fmt::format("_{}_", kCrashName)) == std::string::npos;
  });
  return out;
}

/// A service that crashes again and again is not to do nothing but write clips.
bool ClipService::had_crash_clip() const {
  std::error_code error;
  for (const RecordingFile& file : crash_clips()) {
    const auto written = std::filesystem::last_write_time(files_.path_of(file.name), error);
    const auto age = std::filesystem::file_time_type::clock::now() - written;
    if (!error && age >= age.zero() && age < kCrashClipInterval) return true;
  }
  return false;
}

/// Nor to fill the disk, from which match logs would go.
void ClipService::keep_few_crash_clips() {
  std::size_t kept = 0;
  for (const RecordingFile& file : crash_clips()) {
    if (file.is_pinned || ++kept < kMostCrashClips) continue;
    if (files_.remove(file.name)) log::info("recording {} was removed: it is of an earlier crash", file.name);
  }
}

/// How that went, as the second half of a sentence.
std::string ClipService::write_crash_clip(LeftRings& left, const std::stop_token& stop) {
  const std::shared_ptr<const Config> config = config_.load();
  const double ahead_s = unix_time_s() - steady_s();  // of the steady clock is the other
  const Order order{.name = kCrashName,
                    .why = "the service crashed",
                    .begin_s = static_cast<double>(left.extent().oldest_ns) * 1e-9,
                    .end_s = static_cast<double>(left.extent().newest_ns) * 1e-9};
  std::filesystem::path file;
  std::string problem;
  bool is_finished = false;
  try {
    keep_few_crash_clips();
    files_.make_room(with_reserve(config->recording), events_, left.extent().bytes);
    file = files_.begin(order.name, RecordingFile::Kind::kClip);
    {
      const std::lock_guard lock(mutex_);
      clip_ = {.file = file.filename().string(), .why = order.why};
    }
    ClipWriter writer(file, {.site = config->site,
                             .version = kVersion,
                             .why = order.why,
                             .begin_s = order.begin_s + ahead_s,
                             .end_s = order.end_s + ahead_s});
    while (!stop.stop_requested() && left.write_next(writer, every_nth_of(config->recording.last_seconds))) {
      const std::lock_guard lock(mutex_);
      clip_.frames = left.frames();
      clip_.missing = left.missing();
      clip_.bytes = writer.bytes();
    }
    if (stop.stop_requested()) throw StorageError("the service was stopped");
    if (left.frames() == 0) throw StorageError("no camera has images that can be used");
    writer.add(ClipEvent{left.newest_s(), "alert", "The service crashed"});
    writer.finish();
    is_finished = true;
  } catch (const std::exception& error) {
    problem = error.what();
  }
  try {
    if (!file.empty()) files_.end(file, is_finished);
    // Who starts next makes a whole one.
    const bool is_for_later = !is_finished && stop.stop_requested();
    if (is_for_later) left.put_back();
    if (!file.empty() && (left.frames() == 0 || is_for_later)) files_.remove(file.filename().string());
  } catch (const StorageError& error) {
    log::warning("{}", error.what());
  }
  const std::string name = file.filename().string();
  if (!is_finished && left.frames() > 0) return fmt::format("; clip {} is not whole: {}", name, problem);
  if (!is_finished) return fmt::format("; there is no clip of it: {}", problem);
  log::info("clip {} was written: {} frames, {} missing ({})", name, left.frames(), left.missing(),
            order.why);
  events_.add({.id = "clip_written", .title = fmt::format("Clip {} was written: {}", name, order.why)});
  return fmt::format("; clip {} shows what the cameras saw before", name);
}

void ClipService::write(Order order, const std::stop_token& stop) {
  std::vector<Source> sources;
  double bytes = 0;
  const LastSecondsSettings kept = last_seconds_.status().settings;
  const bool is_in_parts = kept.images == LastSecondsSettings::Images::kFound;
  const int every_nth = every_nth_of(kept);
  order.begin_s -= is_in_parts ? kWholeInterval_s : kKeyInterval_s;
  for (LastSeconds::Ring& ring : last_seconds_.rings()) {
    // At once: what is held is not overwritten while the file is made.
    ring.ring->hold(to_ns(order.begin_s), to_ns(order.end_s));
    const ImageRing::Extent extent = ring.ring->extent();
    const double held_s =
        std::min(static_cast<double>(extent.newest_ns - extent.oldest_ns) * 1e-9, steady_s() - order.begin_s);
    bytes += std::min(ring.bytes_per_s * std::max(0.0, held_s), static_cast<double>(ring.ring->bytes())) +
             ring.bytes_per_s * std::max(0.0, order.end_s - steady_s());
    auto setup_of = [camera = ring.camera](std::uint32_t number) { return camera->setup_for_clip(number); };
    ClipCamera camera(ring.camera_id, every_nth, std::move(setup_of));
    sources.push_back(
        {.from = std::move(ring), .camera = std::move(camera), .dropped_before = extent.dropped});
  }
  std::filesystem::path file;
  std::string problem;
  bool is_finished = false;
  try {
    files_.make_room(with_reserve(config_.load()->recording), events_, static_cast<std::uint64_t>(bytes));
    file = files_.begin(order.name, RecordingFile::Kind::kClip);
    {
      const std::lock_guard lock(mutex_);
      clip_ = {.file = file.filename().string(), .why = order.why};
    }
    const double ahead_s = unix_time_s() - steady_s();  // of the steady clock is the other
    ClipWriter writer(file, {.site = config_.load()->site,
                             .version = kVersion,
                             .why = order.why,
                             .begin_s = order.begin_s + ahead_s,
                             .end_s = order.end_s + ahead_s});
    write_frames(order, writer, sources, stop);
    finish(order, writer, sources);
    is_finished = true;
  } catch (const std::exception& error) {
    problem = error.what();
    log::error("the clip is not written: {}", problem);
  }
  for (Source& source : sources) source.from.ring->let_all_go();
  try {
    if (!file.empty()) files_.end(file, is_finished);
    const bool is_empty = !problem.empty() && std::ranges::none_of(sources, [](const Source& source) {
      return source.camera.has_begun();
    });
    if (!file.empty() && is_empty) files_.remove(file.filename().string());
  } catch (const StorageError& error) {
    log::warning("{}", error.what());
  }
  const std::lock_guard lock(mutex_);
  is_writing_ = false;
  if (!problem.empty()) clip_ = {.problem = problem, .problem_s = steady_s()};
}

void ClipService::write_frames(const Order& order, ClipWriter& writer, std::vector<Source>& sources,
                               const std::stop_token& stop) {
  std::uint64_t checked_bytes = 0;
  std::mutex idle;
  std::condition_variable_any stopped;
  for (;;) {
    const double now_s = steady_s();
    for (Source& source : sources) source.from.ring->hold(to_ns(order.begin_s), to_ns(order.end_s));
    note_end(order, sources);
    while (write_next(writer, sources)) {
      note_end(order, sources);
      if (writer.bytes() - checked_bytes > kCheckDiskEvery) {
        checked_bytes = writer.bytes();
        files_.make_room(with_reserve(config_.load()->recording), events_);
      }
      if (stop.stop_requested()) return;
    }
    look_at_game();
    // Those that were not there when it was looked the last time are there now.
    if (now_s > order.end_s + kLateFrames_s || stop.stop_requested()) return;
    std::unique_lock lock(idle);
    stopped.wait_for(lock, stop, kNextFrames, [] { return false; });
  }
}

/// What finds no room once the clip's time is over is not of the clip.
void ClipService::note_end(const Order& order, std::vector<Source>& sources) {
  if (steady_s() < order.end_s) return;
  for (Source& source : sources) {
    if (!source.dropped_at_end) source.dropped_at_end = source.from.ring->extent().dropped;
  }
}

/// The frame that arrived first of those that are held. False: there is none.
bool ClipService::write_next(ClipWriter& writer, std::vector<Source>& sources) {
  Source* first = nullptr;
  std::int64_t first_ns = 0;
  for (Source& source : sources) {
    const ClipFrame* const frame = source.from.ring->oldest_held();
    if (frame == nullptr || (first != nullptr && frame->info.times.arrived_ns >= first_ns)) continue;
    first = &source;
    first_ns = frame->info.times.arrived_ns;
  }
  if (first == nullptr) return false;
  const ClipFrame& frame = *first->from.ring->oldest_held();
  const std::uint64_t missing = first->camera.missing();
  const bool is_written = first->camera.write(writer, frame);
  first->from.ring->let_go();
  const std::lock_guard lock(mutex_);
  if (is_written) ++clip_.frames;
  clip_.missing += first->camera.missing() - missing;
  clip_.bytes = writer.bytes();
  return true;
}

void ClipService::finish(const Order& order, ClipWriter& writer, std::vector<Source>& sources) {
  const bool is_empty =
      std::ranges::none_of(sources, [](const Source& source) { return source.camera.has_begun(); });
  if (is_empty) throw StorageError("no camera has images of that time in memory");
  // Those that found no room while it was written, and after which none was kept.
  for (Source& source : sources) {
    const std::uint64_t dropped =
        source.dropped_at_end.value_or(source.from.ring->extent().dropped) - source.dropped_before;
    const std::uint64_t missing = dropped - std::min(dropped, source.camera.missing());
    source.camera.note_missing(writer, missing);
    const std::lock_guard lock(mutex_);
    clip_.missing += missing;
  }
  std::vector<ClipEvent> events;
  {
    const std::lock_guard lock(mutex_);
    const double ahead_s = unix_time_s() - steady_s();
    for (const ClipEvent& event : recent_) {
      if (event.time_s >= order.begin_s + ahead_s - 1 && event.time_s <= order.end_s + ahead_s + 1)
        events.push_back(event);
    }
  }
  for (const ClipEvent& event : events) writer.add(event);
  writer.finish();
  Clip done;
  {
    const std::lock_guard lock(mutex_);
    clip_.bytes = writer.bytes();
    done = clip_;
  }
  log::info("clip {} was written: {} frames, {} missing, {} bytes ({})", done.file, done.frames, done.missing,
            done.bytes, order.why);
  events_.add(
      {.id = "clip_written", .title = fmt::format("Clip {} was written", done.file), .who = order.who});
}

std::vector<Route> ClipService::routes() {
  constexpr const char* kClip = "/api/recordings/clips/([^/]+)";
  Route download{"GET", kClip, [this](const Request& request) { return get_clip(request); }};
  download.streams = true;
  return {{"GET", "/api/recordings/clips", [this](const Request&) { return json_response(to_json()); }},
          // Also while a match locks the settings: that is when somebody wants one.
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

Response ClipService::make_clip(const Request& request) {
  const Json body = request.body.empty() ? Json::object() : body_json(request);
  check_keys(body, {"seconds", "seconds_after", "name"});
  const ClipSettings settings = config_.load()->recording.clips;
  const auto number = [&](const char* key, double least, double otherwise) {
    if (!body.contains(key)) return otherwise;
    constexpr double kMost_s = 600;
    const bool is_good =
        body[key].is_number() && body[key].get<double>() >= least && body[key].get<double>() <= kMost_s;
    if (!is_good)
      throw HttpError(400, fmt::format("/{}: expected a number of seconds, {} to {}", key, least, kMost_s));
    return body[key].get<double>();
  };
  const double before_s = number("seconds", 0.5, settings.seconds), after_s = number("seconds_after", 0, 0);
  const std::string name = body.contains("name") ? asked_name(body) : "by_hand";
  const LastSeconds::Status status = last_seconds_.status();
  if (status.bytes == 0) {
    throw HttpError(409, status.wanted_bytes == 0
                             ? "no images are kept in memory: /recording/last_seconds/memory_mb is 0"
                             : "no images are in memory yet; try again in a few seconds");
  }
  const double now_s = steady_s();
  if (!put({.name = name,
            .why = "kept by hand",
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
                          "the field: hand it on only if they agree"};
}

void ClipService::report(HealthReport& report) const {
  const LastSeconds::Status status = last_seconds_.status();
  LastSecondsFacts facts{
      .is_wanted = status.wanted_bytes > 0, .is_there = status.bytes > 0, .problem = status.problem};
  double least_s = std::numeric_limits<double>::max();
  for (const LastSeconds::CameraStatus& camera : status.cameras) {
    if (camera.bytes > 0) least_s = std::min(least_s, camera.seconds);
  }
  if (facts.is_there) facts.seconds = least_s;
  {
    const std::lock_guard lock(mutex_);
    if (steady_s() - clip_.problem_s < kFailureIsTold_s) facts.clip_problem = clip_.problem;
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
