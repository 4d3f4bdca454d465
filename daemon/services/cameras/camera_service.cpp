// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/camera_service.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "config/backends.h"
#include "services/cameras/camera_json.h"
#include "services/cameras/camera_routes.h"
#include "services/network/teams.h"
#include "vision/detections_json.h"
#include "vision/flood_cut.h"
#include "vision/label_picture.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// What is asked of a camera. A player's speed is for its viewer to choose.
std::optional<double> wanted_fps(const Json& source) {
  const auto rate = source.find("frame_rate_hz");
  if (source.at("backend") == "files" || rate == source.end() || !rate->is_number()) return std::nullopt;
  const double fps = rate->get<double>();
  return fps > 0 ? std::optional(fps) : std::nullopt;
}

std::array<double, 2> robot_heights_mm(const Config& config, const RefereeListener& referee) {
  const auto teams = teams_now(config.teams, referee.team_names());
  return {teams[0].robot_height_mm, teams[1].robot_height_mm};
}

/// A camera's finished frame on loan. The camera is held too, because the frame lies in its ring.
struct HeldFrame {
  std::shared_ptr<RunningCamera> camera;
  FrameRef frame;
};
struct NewestFrame {
  std::uint64_t version;
  std::shared_ptr<const HeldFrame> hold;
};

std::optional<NewestFrame> hold_frame(std::shared_ptr<RunningCamera> camera, std::uint64_t newer_than,
                                      std::chrono::milliseconds timeout) {
  if (!camera) return std::nullopt;
  auto newest = camera->pipeline().finished().wait_newer(newer_than, timeout);
  if (!newest) return std::nullopt;
  return NewestFrame{newest->version, std::make_shared<const HeldFrame>(
                                          HeldFrame{std::move(camera), std::move(newest->value)})};
}

CameraNow now_of(const RunningCamera& camera) {
  const auto settings = camera.settings();
  return {settings->id, settings, camera.pipeline().setup(), camera.health()};
}

}  // namespace

/// A change of the list of cameras, made ready.
struct CameraService::Prepared {
  struct Changed {
    std::shared_ptr<RunningCamera> camera;
    RunningCamera::Change change;
  };
  std::vector<Changed> changed;                        // that go on, whatever changes about them
  std::vector<std::shared_ptr<RunningCamera>> added;   // not started yet
  std::list<std::shared_ptr<RunningCamera>> removed;
  std::shared_ptr<const Running> running;              // all that are to run
};

CameraService::CameraService(const Snapshot<Config>& config, MulticastSender& multicast,
                             const RefereeListener& referee, LoadTable load_table)
    : config_(config), multicast_(multicast), referee_(referee), load_table_(std::move(load_table)) {}

CameraService::~CameraService() {
  for (const auto& camera : running()) camera->ask_to_stop();
}

std::shared_ptr<RunningCamera> CameraService::find(int camera_id) const {
  const auto running = running_.load();
  const auto found = running->find(camera_id);
  return found == running->end() ? nullptr : found->second;
}

std::vector<std::shared_ptr<RunningCamera>> CameraService::running() const {
  std::vector<std::shared_ptr<RunningCamera>> out;
  const auto running = running_.load();
  for (const auto& [id, camera] : *running) out.push_back(camera);
  return out;
}

std::vector<CameraNow> CameraService::all() const {
  std::vector<CameraNow> out;
  for (const auto& camera : running()) out.push_back(now_of(*camera));
  return out;
}

CameraNow CameraService::get(int camera_id) const {
  const auto camera = find(camera_id);
  if (!camera) throw HttpError(404, fmt::format("no camera {}", camera_id));
  return now_of(*camera);
}

std::optional<LentFrame> CameraService::wait_frame(int camera_id, std::uint64_t newer_than,
                                                   std::chrono::milliseconds timeout) {
  auto camera = find(camera_id);
  if (!camera) throw CaptureError("the camera is not in the settings any more");
  const auto held = hold_frame(std::move(camera), newer_than, timeout);
  if (!held) return std::nullopt;
  const Frame& frame = *held->hold->frame;
  return LentFrame{held->version,       held->hold,       frame.image.view(), frame.info.times.t_capture_s,
                   frame.robots.robots, frame.info.whole, frame.info.number,  frame.balls.balls};
}

bool CameraService::change_light(int camera_id, const std::shared_ptr<const Lut>& accepted,
                                 std::shared_ptr<const Lut> adapted) {
  const std::lock_guard lock(mutex_);
  const auto camera = find(camera_id);
  return camera && camera->change_light(accepted, std::move(adapted));
}

std::vector<std::uint32_t> CameraService::camera_ids() const {
  std::vector<std::uint32_t> ids;
  const auto running = running_.load();
  for (const auto& [id, camera] : *running) ids.push_back(static_cast<std::uint32_t>(id));
  return ids;
}

std::optional<View> CameraService::wait_view(std::uint32_t camera_id, std::uint64_t newer_than_version,
                                             std::chrono::milliseconds timeout) {
  const auto newest = hold_frame(find(static_cast<int>(camera_id)), newer_than_version, timeout);
  if (!newest) return std::nullopt;
  const auto& hold = newest->hold;
  const Frame& frame = *hold->frame;
  View view{newest->version,
            hold,
            frame.image.view(),
            camera_id,
            frame.info.number,
            frame.info.times.t_capture_s,
            detections_json(frame.robots, frame.balls),
            {},
            {}};
  if (frame.runs.width > 0) {
    const auto labels = hold->camera->pipeline().setup()->world.labels;
    view.regions = [hold, labels] { return regions_json(hold->frame->regions, *labels); };
    view.draw_labels = [hold, labels](std::vector<std::uint8_t>& buffer) {
      return draw_label_picture(hold->frame->runs, buffer, *labels);
    };
  }
  return view;
}

Commit CameraService::prepare(const SettingsChange& change) {
  Prepared prepared;
  const auto old = running_.load();
  auto running = std::make_shared<Running>();
  std::vector<std::optional<NewSetup>> setups;
  for (std::size_t i = 0; i < change.next.cameras.size(); ++i) {
    const CameraSettings& camera = change.next.cameras[i];
    const auto found = old->find(camera.id);
    if (found == old->end()) {
      setups.push_back(make_setup(change.next, i, std::nullopt, load_table_));
      continue;
    }
    const auto settings = found->second->settings();
    const auto setup = found->second->pipeline().setup();
    setups.push_back(make_setup(change.next, i, CameraInUse{change.now, *settings, *setup}, load_table_));
  }
  for (std::size_t i = 0; i < change.next.cameras.size(); ++i) {
    const CameraSettings& camera = change.next.cameras[i];
    if (old->contains(camera.id)) continue;
    std::shared_ptr<CameraTotals> totals;
    {
      const std::lock_guard lock(mutex_);
      auto& known = totals_[camera.id];
      if (!known) known = std::make_shared<CameraTotals>();
      totals = known;
    }
    prepared.added.push_back(
        std::make_shared<RunningCamera>(camera, std::move(setups[i]->setup), multicast_, totals));
    running->emplace(camera.id, prepared.added.back());
  }
  // Last, when all the rest is known to be allowed: this may set controls of cameras.
  for (std::size_t i = 0; i < change.next.cameras.size(); ++i) {
    const CameraSettings& camera = change.next.cameras[i];
    const auto found = old->find(camera.id);
    if (found == old->end()) continue;
    prepared.changed.push_back(
        {found->second, found->second->prepare(camera, std::move(setups[i]),
                                               fmt::format("/cameras/{}/source/controls", i))});
    running->emplace(camera.id, found->second);
  }
  for (const auto& [id, camera] : *old) {
    if (!running->contains(id)) prepared.removed.push_back(camera);
  }
  prepared.running = std::move(running);
  return [this, held = std::move(prepared)]() mutable noexcept { commit(held); };
}

void CameraService::commit(Prepared& prepared) noexcept {
  std::set<int> changed;  // ids of the cameras that do not go on showing what they showed
  {
    const std::lock_guard lock(mutex_);
    const auto heights_mm = robot_heights_mm(*config_.load(), referee_);
    for (auto& [camera, change] : prepared.changed) {
      const int id = change.settings->id;
      if (camera->commit(change, heights_mm)) changed.insert(id);
    }
    for (const auto& camera : prepared.added) camera->change_robot_heights(heights_mm);
    for (const auto& camera : prepared.removed) {
      changed.insert(camera->settings()->id);
      camera->ask_to_stop();
    }
    running_.store(std::move(prepared.running));
    gone_.splice(gone_.end(), prepared.removed);
  }
  for (CameraObserver* observer : observers_) observer->cameras_changed(changed);
  for (const auto& camera : prepared.added) camera->start();
}

void CameraService::each_second() {
  std::list<std::shared_ptr<RunningCamera>> ended;
  {
    const std::lock_guard lock(mutex_);
    ended.swap(gone_);
  }
  ended.clear();  // waits for cameras that do not answer
  watch_.look(running());
}

void CameraService::update_robot_heights() {
  const std::lock_guard lock(mutex_);
  const auto teams = teams_now(config_.load()->teams, referee_.team_names());
  // The names come from the network: as JSON, so that one cannot forge a line of the log.
  log::info("teams: yellow {} {} mm, blue {} {} mm", Json(teams[0].name).dump(), teams[0].robot_height_mm,
            Json(teams[1].name).dump(), teams[1].robot_height_mm);
  for (const auto& camera : running())
    camera->change_robot_heights({teams[0].robot_height_mm, teams[1].robot_height_mm});
}

std::vector<CameraFacts> CameraService::facts() const {
  std::vector<CameraFacts> out;
  for (const auto& camera : running()) {
    const auto settings = camera->settings();
    const int id = settings->id;
    const auto last_minute = watch_.timeline().sum(id, 60);
    const auto counters = camera->pipeline().counters();
    const bool is_flooded = counters.flood.blocks > 0 && counters.frames_since_flood <= last_minute.frames;
    const auto labels = camera->pipeline().setup()->world.labels;
    out.push_back({.id = id,
                   .backend = settings->source.at("backend"),
                   .wanted_fps = wanted_fps(settings->source),
                   .health = camera->health(),
                   .latency_p99_ms = camera->latency().percentiles().p99_us * 1e-3,
                   .last_minute = last_minute,
                   .last_seconds = watch_.timeline().sum(id, CameraFacts::kLastSeconds),
                   .exposure = watch_.exposure(id),
                   .flood = is_flooded ? flood_text(counters.flood, labels->name(counters.flood.label))
                                       : std::string()});
  }
  return out;
}

void CameraService::report(HealthReport& report) const {
  report_cameras(facts(), report);
}

std::string CameraService::summary() const {
  return camera_summary(facts());
}

std::string CameraService::hanging() const {
  std::vector<CameraProgress> progress;
  for (const auto& camera : running()) progress.push_back({camera->settings()->id, camera->health()});
  return find_hanging(progress, steady_ns());
}

std::string CameraService::missing() const {
  std::vector<CameraProgress> progress;
  for (const auto& camera : running()) progress.push_back({camera->settings()->id, camera->health()});
  return find_missing(progress);
}

void CameraService::add_status(Json& status, const HealthReport&) const {
  status["cameras"] = Json::array();
  for (const auto& camera : running()) status["cameras"].push_back(camera_json(*camera));
}

void CameraService::add_diagnostics(Json& diagnostics) const {
  diagnostics["cameras"] = Json::array();
  for (const auto& camera : running())
    diagnostics["cameras"].push_back(
        camera_diagnostics_json(*camera, watch_.exposure(camera->settings()->id)));
}

void CameraService::write_metrics(MetricsText& out) const {
  write_camera_metrics(out, running());
}

std::vector<SupportFile> CameraService::support_files() const {
  std::vector<SupportFile> files{{"timeline.json", "the last ten minutes, second by second", [this] {
                                    return watch_.timeline().to_json(600).dump(2) + "\n";
                                  }}};
  for (const auto& camera : running()) {
    const int id = camera->settings()->id;
    files.push_back({fmt::format("camera_{}/picture.jpg", id), "its newest image, in full size",
                     [camera] { return full_jpeg(*camera); }});
  }
  return files;
}

std::vector<Route> CameraService::routes() {
  return camera_routes({.views = *this,
                        .timeline = watch_.timeline(),
                        .find = [this](int id) { return find(id); }});
}

}  // namespace sslv
