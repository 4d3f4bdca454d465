// SPDX-License-Identifier: Apache-2.0
#include "services/recording/replay_service.h"

#include "base/background.h"
#include "base/clock.h"
#include "base/error.h"
#include "replay/replay_clip.h"
#include "services/cameras/camera_routes.h"
#include "services/recording/recording_request.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::size_t kMaxDifferences = 2000;
constexpr std::array<std::string_view, 3> kWithNames{"recorded_settings", "settings_now", "learnt_colors"};
constexpr std::array<const char*, 4> kStateNames{"idle", "running", "done", "failed"};
constexpr int kMaxPlace = 100'000'000;
constexpr double kKeptOpen_s = 60;
constexpr std::chrono::seconds kCloseInterval{1};  // for closing unused recordings

const char* name_of(ClipDifference::Kind kind) {
  switch (kind) {
    case ClipDifference::Kind::kFound: return "found";
    case ClipDifference::Kind::kLost: return "lost";
    case ClipDifference::Kind::kMoved: return "moved";
    case ClipDifference::Kind::kIdChanged: return "id";
  }
  return "";
}

std::string what_of(const ClipDifference& difference) {
  if (!difference.team) return "ball";
  const int id = difference.id_after >= 0 ? difference.id_after : difference.id_before;
  return fmt::format("{} {}", name_of(*difference.team), id);
}

Json frames_json(const ClipReader& clip) {
  const double begin_s = clip.entries().empty() ? clip.about().begin_s : clip.entries().front().t_capture_s;
  const double end_s = clip.entries().empty() ? begin_s : clip.entries().back().t_capture_s;
  Json cameras = Json::array(), events = Json::array();
  for (const ClipReader::Camera& camera : clip.cameras()) {
    Json times = Json::array(), numbers = Json::array();
    for (const std::size_t place : camera.frames) {
      times.push_back(clip.entries()[place].t_capture_s - begin_s);
      numbers.push_back(clip.entries()[place].number);
    }
    cameras.push_back({{"id", camera.id},
                       {"missing", camera.missing},
                       {"places", camera.frames},
                       {"times_s", std::move(times)},
                       {"numbers", std::move(numbers)}});
  }
  for (const ClipEvent& event : clip.events())
    events.push_back({{"time_s", event.time_s - begin_s}, {"kind", event.kind}, {"text", event.text}});
  return {{"begin_s", begin_s},           {"seconds", end_s - begin_s},      {"why", clip.about().why},
          {"site", clip.about().site},    {"version", clip.about().version}, {"events", std::move(events)},
          {"cameras", std::move(cameras)}};
}

/// The frame that a request names; valid until the reader's next read(). Throws HttpError and ClipError.
const ClipFrame& frame_of(ClipReader& clip, const Request& request) {
  const int place = read_whole_number("frame", request.matches.at(2), 0, kMaxPlace);
  if (static_cast<std::size_t>(place) >= clip.entries().size())
    throw HttpError(404, fmt::format("the clip has {} frames", clip.entries().size()));
  return clip.read(static_cast<std::size_t>(place));
}

}  // namespace

ReplayService::ReplayService(const Snapshot<Config>& config, const RecordingFiles& files, Cameras& cameras,
                             LearntTable learnt_table)
    : config_(config),
      files_(files),
      cameras_(cameras),
      learnt_table_(std::move(learnt_table)),
      thread_([this](const std::stop_token& stop) {
        become_background_thread("compare", 15);
        compare(stop);
      }) {}

std::vector<Route> ReplayService::routes() {
  const auto call = [this](Response (ReplayService::*handle)(const Request&)) -> Handler {
    return [this, handle](const Request& request) { return (this->*handle)(request); };
  };
  return {{"GET", "/api/recordings/clips/([^/]+)/frames", call(&ReplayService::get_frames)},
          {"GET", R"(/api/recordings/clips/([^/]+)/frames/(\d+))", call(&ReplayService::get_frame)},
          {"GET", R"(/api/recordings/clips/([^/]+)/frames/(\d+)/picture)", call(&ReplayService::get_picture)},
          {"GET", "/api/recordings/logs/([^/]+)/at", call(&ReplayService::get_moment)},
          // Allowed while a match locks the settings: it changes no settings.
          {"POST", "/api/recordings/clips/([^/]+)/compare", call(&ReplayService::start_comparison),
           Needs::kChange},
          {"GET", "/api/recordings/compare",
           [this](const Request&) { return json_response(comparison_state()); }}};
}

RecordingFile ReplayService::find(const Request& request, RecordingFile::Kind kind) const {
  auto file = files_.find(request.matches.at(1));
  if (!file || file->kind != kind) throw HttpError(404, "there is no such recording");
  if (file->is_open) throw HttpError(409, "it is still being written");
  return *std::move(file);
}

template <class Reader>
std::shared_ptr<ReplayService::Open<Reader>> ReplayService::opened(std::vector<OpenOne<Reader>>& list,
                                                                   const RecordingFile& file) {
  std::error_code error;
  const auto written = std::filesystem::last_write_time(files_.path_of(file.name), error);
  OpenOne<Reader> evicted;  // destroyed after the lock is released: closing may wait for the disk
  const std::lock_guard lock(open_mutex_);
  const auto found = std::ranges::find_if(list, [&](const auto& one) {
    return one.name == file.name && one.bytes == file.bytes && one.written == written;
  });
  if (found != list.end()) {
    std::rotate(list.begin(), found, found + 1);
  } else {
    list.insert(list.begin(), {file.name, file.bytes, written, 0, std::make_shared<Open<Reader>>()});
    if (list.size() > kMaxOpen) {
      evicted = std::move(list.back());
      list.pop_back();
    }
  }
  list.front().used_s = steady_s();
  return list.front().open;
}

/// Closes unused and removed recordings, to free their memory and disk space. Releases the lock before it
/// accesses the disk or destroys a reader: a disk that hangs delays no other request.
template <class Reader>
void ReplayService::close_unused(std::vector<OpenOne<Reader>>& list) {
  std::vector<OpenOne<Reader>> all;
  {
    const std::lock_guard lock(open_mutex_);
    all = list;
  }
  for (const OpenOne<Reader>& one : all) {
    if (steady_s() - one.used_s < kKeptOpen_s && files_.find(one.name).has_value()) continue;
    const std::lock_guard lock(open_mutex_);
    std::erase_if(list, [&](const auto& other) { return other.open == one.open; });
  }
}

void ReplayService::close_unused() {
  if (steady_s() - looked_s_ < 1) return;
  looked_s_ = steady_s();
  close_unused(clips_);
  close_unused(logs_);
}

template <class Use>
Response ReplayService::with_clip(const RecordingFile& file, const std::stop_token& stop, const Use& use) {
  const auto open = opened(clips_, file);
  const std::lock_guard lock(open->mutex);
  try {
    if (!open->reader) open->reader = std::make_unique<ClipReader>(files_.path_of(file.name), stop);
    return use(*open->reader);
  } catch (const ClipError& error) {
    throw HttpError(422, error.what());
  }
}

Response ReplayService::get_frames(const Request& request) {
  return with_clip(find(request, RecordingFile::Kind::kClip), request.stop,
                   [](const ClipReader& clip) { return json_response(frames_json(clip)); });
}

Response ReplayService::get_frame(const Request& request) {
  return with_clip(find(request, RecordingFile::Kind::kClip), request.stop, [&](ClipReader& clip) {
    const ClipFrame& frame = frame_of(clip, request);
    Json out =
        detections_json_of(frame.packet).value_or(Json{{"robots", Json::array()}, {"balls", Json::array()}});
    out.update({{"camera", frame.info.camera_id},
                {"number", frame.info.number},
                {"time_s", frame.info.times.t_capture_s - clip.entries().front().t_capture_s},
                {"width", frame.image.width},
                {"height", frame.image.height}});
    return json_response(out);
  });
}

Response ReplayService::get_picture(const Request& request) {
  return with_clip(find(request, RecordingFile::Kind::kClip), request.stop, [&](ClipReader& clip) {
    const ImageView& image = frame_of(clip, request).image;
    if (image.empty()) throw HttpError(422, "this frame's image was not kept, or only in part");
    return jpeg_response(image, request);
  });
}

Response ReplayService::get_moment(const Request& request) {
  constexpr double kMax_s = 1e6;
  const auto text = request.query.find("time_s");
  if (text == request.query.end()) throw HttpError(400, "time_s: expected seconds since the log's beginning");
  const double at_s = read_number("time_s", text->second, 0, kMax_s);
  const RecordingFile file = find(request, RecordingFile::Kind::kMatchLog);
  // Only RecordingService's thread makes the index: a log may be long, or may have been crafted to unpack
  // endlessly.
  if (!file.index && !file.problem.empty()) throw HttpError(422, file.problem);
  if (!file.index) throw HttpError(409, "it is still being read; try again in a moment");
  const auto open = opened(logs_, file);
  const std::lock_guard lock(open->mutex);
  try {
    if (!open->reader) open->reader = std::make_unique<MatchMoments>(files_.path_of(file.name), file.index);
    if (const auto moment = open->reader->at(at_s, request.stop)) return json_response(*moment);
  } catch (const StorageError& error) {
    throw HttpError(422, error.what());
  }
  throw HttpError(409, "it is still being read up to this time; try again in a moment");
}

Response ReplayService::start_comparison(const Request& request) {
  const RecordingFile file = find(request, RecordingFile::Kind::kClip);
  const Json body = body_json(request);
  check_keys(body, {"camera", "with"});
  Comparison order{.state = Comparison::State::kRunning, .clip = file.name};
  if (body.contains("with")) {
    const auto with =
        std::ranges::find(kWithNames, body["with"].is_string() ? body["with"].get<std::string>() : "");
    if (with == kWithNames.end())
      throw HttpError(400, fmt::format("/with: expected one of {}", fmt::join(kWithNames, ", ")));
    order.with = static_cast<With>(with - kWithNames.begin());
  }
  if (body.contains("camera")) {
    const bool is_number = body["camera"].is_number_unsigned() && body["camera"].get<std::uint64_t>() <= 255;
    order.camera_id = is_number ? body["camera"].get<int>() : -1;
  }
  with_clip(file, request.stop, [&](const ClipReader& clip) {
    const auto& cameras = clip.cameras();
    if (cameras.empty()) throw HttpError(422, "the clip has no frames");
    if (!body.contains("camera")) order.camera_id = static_cast<int>(cameras.front().id);
    const auto* camera = clip.camera(static_cast<std::uint32_t>(order.camera_id));
    if (order.camera_id < 0 || camera == nullptr)
      throw HttpError(400, "/camera: expected the id of a camera in the clip");
    order.frames = camera->frames.size();
    return Response{};
  });
  // Use the running service's tables: the replay cannot load saved tables by name.
  if (order.with == With::kSettingsNow) order.table = cameras_.get(order.camera_id).context().adapted_lut;
  if (order.with == With::kLearntColors) {
    order.table = learnt_table_(order.camera_id);
    if (!order.table) throw HttpError(409, "this camera has no learnt colours to accept");
  }
  {
    const std::lock_guard lock(mutex_);
    if (comparison_.state == Comparison::State::kRunning)
      throw HttpError(409, "another comparison is running; try again when it is done");
    comparison_ = std::move(order);
  }
  ordered_.notify_one();
  return json_response(comparison_state(), 202);
}

Json ReplayService::comparison_state() const {
  const std::lock_guard lock(mutex_);
  return {{"state", kStateNames[static_cast<std::size_t>(comparison_.state)]},
          {"clip", comparison_.clip},
          {"camera", comparison_.camera_id},
          {"with", kWithNames[static_cast<std::size_t>(comparison_.with)]},
          {"done", comparison_.done},
          {"frames", comparison_.frames},
          {"error", comparison_.error},
          {"result", comparison_.result}};
}

void ReplayService::compare(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    Comparison order;
    {
      std::unique_lock lock(mutex_);
      const bool is_ordered = ordered_.wait_for(
          lock, stop, kCloseInterval, [&] { return comparison_.state == Comparison::State::kRunning; });
      if (stop.stop_requested()) return;
      if (is_ordered) order = comparison_;
    }
    close_unused();
    if (order.state != Comparison::State::kRunning) continue;
    Json result = nullptr;
    std::string error;
    try {
      result = compared(order, stop);
    } catch (const std::exception& problem) {
      error = problem.what();
    }
    const std::lock_guard lock(mutex_);
    comparison_.state = error.empty() ? Comparison::State::kDone : Comparison::State::kFailed;
    comparison_.error = error;
    comparison_.result = std::move(result);
    comparison_.table.reset();
  }
}

Json ReplayService::compared(const Comparison& order, const std::stop_token& stop) {
  ClipReader clip(files_.path_of(order.clip), stop);
  OtherSetup other{.path = "the settings now", .table = order.table};
  if (order.with == With::kSettingsNow) other.settings = config_.load();
  ClipReplay replay(clip, static_cast<std::uint32_t>(order.camera_id), {},
                    order.with == With::kRecordedSettings ? std::nullopt : std::optional(other));
  ClipComparison comparison;
  ClipReplay::Result result;
  while (!stop.stop_requested() && replay.next(result)) {
    comparison.add(result.recorded->packet, result.packet);
    close_unused();
    const std::lock_guard lock(mutex_);
    ++comparison_.done;
  }
  const CompareLimits limits;
  const DifferenceCounts &robots = comparison.robots(), &balls = comparison.balls();
  Json differences = Json::array();
  const ClipReader::Camera& camera = *clip.camera(static_cast<std::uint32_t>(order.camera_id));
  std::size_t at = 0;  // index in the camera's frames, which are in the same order
  const double begin_s = clip.entries().front().t_capture_s;
  for (const FrameDifferences& frame : comparison.different_frames()) {
    while (at + 1 < camera.frames.size() && clip.entries()[camera.frames[at]].number != frame.number) ++at;
    for (const ClipDifference& one : frame.differences) {
      if (differences.size() >= kMaxDifferences) break;
      differences.push_back({{"place", camera.frames[at]},
                             {"time_s", frame.t_capture_s - begin_s},
                             {"kind", name_of(one.kind)},
                             {"what", what_of(one)},
                             {"by_mm", one.moved_mm},
                             {"by_deg", one.turned_deg},
                             {"x_mm", one.x_mm},
                             {"y_mm", one.y_mm},
                             {"pixel_x", one.pixel_x},
                             {"pixel_y", one.pixel_y}});
    }
  }
  return {{"exact", replay.doubts().empty()},
          {"why_not_exact", replay.doubts().empty() ? "" : replay.doubts().front()},
          {"frames", comparison.frames()},
          {"frames_that_differ", comparison.frames_that_differ()},
          {"frames_with_other_bytes", comparison.frames_with_other_bytes()},
          {"found", robots.found + balls.found},
          {"lost", robots.lost + balls.lost},
          {"moved", robots.moved + balls.moved},
          {"id_changed", robots.id_changed},
          {"largest_mm", std::max(robots.max_moved_mm, balls.max_moved_mm)},
          {"threshold_mm", limits.moved_mm},
          {"differences", std::move(differences)}};
}

}  // namespace sslv
