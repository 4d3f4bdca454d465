// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/running_cameras.h"

#include "base/clock.h"
#include "base/log.h"
#include "services/cameras/camera_report.h"
#include "services/network/teams.h"
#include "vision/detections_json.h"
#include "vision/label_picture.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

std::array<double, 2> robot_heights_mm(const Config& config, const RefereeListener& referee) {
  const auto teams = teams_now(config.teams, referee.team_names());
  return {teams[0].robot_height_mm, teams[1].robot_height_mm};
}

/// A camera's finished frame, on loan. Also keeps the camera alive, whose ring contains the frame.
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

/// Effects of a change on the list of cameras.
struct RunningCameras::Planned {
  struct Changed {
    std::shared_ptr<RunningCamera> camera;
    RunningCamera::Change change;
  };
  struct Added {
    CameraSettings settings;
    NewSetup setup;
  };
  std::shared_ptr<const Config> config;
  std::vector<Changed> changed;  // cameras that stay in the settings, even unchanged
  std::vector<Added> added;
  List removed, started{};                   // started: made by get_ready() from `added`
  std::shared_ptr<const Running> running{};  // made by get_ready(): all cameras that will run
};

RunningCameras::RunningCameras(const Snapshot<Config>& config, MulticastSender& multicast, FieldIntake& field,
                               const RefereeListener& referee, LoadTable load_table)
    : config_(config),
      multicast_(multicast),
      field_(field),
      referee_(referee),
      load_table_(std::move(load_table)) {}

void RunningCameras::ask_to_stop() {
  for (const auto& camera : list()) {
    camera->ask_to_stop();
    camera->end_control_calls();
  }
  for (const auto& camera : *gone_.load()) camera->end_control_calls();
}

std::shared_ptr<RunningCamera> RunningCameras::find(int camera_id) const {
  const auto running = running_.load();
  const auto found = running->find(camera_id);
  return found == running->end() ? nullptr : found->second;
}

RunningCameras::List RunningCameras::list() const {
  List out;
  const auto running = running_.load();
  for (const auto& [id, camera] : *running) out.push_back(camera);
  return out;
}

std::vector<CameraNow> RunningCameras::all() const {
  std::vector<CameraNow> out;
  for (const auto& camera : list()) out.push_back(now_of(*camera));
  return out;
}

CameraNow RunningCameras::get(int camera_id) const {
  const auto camera = find(camera_id);
  if (!camera) throw HttpError(404, fmt::format("no camera {}", camera_id));
  return now_of(*camera);
}

std::optional<LentFrame> RunningCameras::wait_frame(int camera_id, std::uint64_t newer_than,
                                                    std::chrono::milliseconds timeout) {
  auto camera = find(camera_id);
  if (!camera) throw CaptureError("the camera is no longer in the settings");
  const auto held = hold_frame(std::move(camera), newer_than, timeout);
  if (!held) return std::nullopt;
  const Frame& frame = *held->hold->frame;
  return LentFrame{.version = held->version,
                   .hold = held->hold,
                   .image = frame.image.view(),
                   .t_capture_s = frame.info.times.t_capture_s,
                   .robots = frame.robots.robots,
                   .whole = frame.info.whole,
                   .number = frame.info.number,
                   .balls = frame.balls.balls,
                   .second_robots = frame.robots.second_robots};
}

bool RunningCameras::change_light(int camera_id, const std::shared_ptr<const Lut>& accepted,
                                  std::shared_ptr<const Lut> adapted) {
  const std::lock_guard lock(mutex_);
  const auto camera = find(camera_id);
  return camera && camera->change_light(accepted, std::move(adapted));
}

std::map<int, std::shared_ptr<RecordedCamera>> RunningCameras::recorded() const {
  std::map<int, std::shared_ptr<RecordedCamera>> out;
  const auto running = running_.load();
  for (const auto& [id, camera] : *running) out.emplace(id, camera->recorded());
  return out;
}

std::vector<std::uint32_t> RunningCameras::camera_ids() const {
  std::vector<std::uint32_t> ids;
  const auto running = running_.load();
  for (const auto& [id, camera] : *running) ids.push_back(static_cast<std::uint32_t>(id));
  return ids;
}

std::optional<View> RunningCameras::wait_view(std::uint32_t camera_id, std::uint64_t newer_than_version,
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
            misses_json(frame.robots),
            {},
            {}};
  if (frame.runs.width > 0) {
    const auto labels = hold->camera->pipeline().setup()->context.labels;
    view.regions = [hold, labels] { return regions_json(hold->frame->regions, *labels); };
    view.draw_labels = [hold, labels](std::vector<std::uint8_t>& buffer) {
      return draw_label_picture(hold->frame->runs, buffer, *labels);
    };
  }
  return view;
}

Plan RunningCameras::plan(const SettingsChange& change) {
  const auto planned = std::make_shared<Planned>();
  planned->config = std::make_shared<const Config>(change.next);
  const auto old = running_.load();
  std::set<int> ids;
  for (std::size_t i = 0; i < change.next.cameras.size(); ++i) {
    const CameraSettings& settings = change.next.cameras[i];
    ids.insert(settings.id);
    const auto found = old->find(settings.id);
    if (found == old->end()) {
      planned->added.push_back({settings, *plan_setup(change.next, i, std::nullopt, load_table_)});
      continue;
    }
    const auto& camera = found->second;
    const auto before = camera->settings();
    const auto setup = camera->pipeline().setup();
    auto next = plan_setup(change.next, i, CameraInUse{change.now, *before, *setup}, load_table_);
    planned->changed.push_back({camera, camera->plan(settings, planned->config, std::move(next),
                                                     fmt::format("/cameras/{}/source/controls", i))});
  }
  for (const auto& [id, camera] : *old) {
    if (!ids.contains(id)) planned->removed.push_back(camera);
  }
  return {.get_ready = [this, planned] { get_ready(*planned); },
          .apply = [this, planned]() noexcept { apply(*planned); },
          .outcome =
              [planned] {
                std::vector<std::string> out;
                for (const auto& [camera, of_camera] : planned->changed)
                  for (std::string& line : camera->outcome(of_camera)) out.push_back(std::move(line));
                return out;
              }};
}

void RunningCameras::get_ready(Planned& planned) {
  auto running = std::make_shared<Running>();
  for (auto& [settings, setup] : planned.added) {
    std::shared_ptr<CameraTotals> totals;
    {
      const std::lock_guard lock(mutex_);
      auto& known = totals_[settings.id];
      if (!known) known = std::make_shared<CameraTotals>();
      totals = known;
    }
    setup.make_stages(settings);
    planned.started.push_back(std::make_shared<RunningCamera>(
        settings, std::move(setup.setup), planned.config, multicast_, field_.add(), totals));
    running->emplace(settings.id, planned.started.back());
  }
  for (auto& [camera, change] : planned.changed) {
    camera->get_ready(change);
    running->emplace(change.settings->id, camera);
  }
  planned.running = std::move(running);
}

void RunningCameras::apply(Planned& planned) noexcept {
  std::set<int> changed;  // ids of the cameras that now show something else
  {
    const std::lock_guard lock(mutex_);
    const auto heights_mm = robot_heights_mm(*config_.load(), referee_);
    for (auto& [camera, change] : planned.changed) {
      const int id = change.settings->id;
      if (camera->apply(change, heights_mm)) changed.insert(id);
    }
    for (const auto& camera : planned.started) camera->change_robot_heights(heights_mm);
    List gone = *gone_.load();
    for (const auto& camera : planned.removed) {
      changed.insert(camera->settings()->id);
      camera->ask_to_stop();
      gone.push_back(camera);
    }
    running_.store(std::move(planned.running));
    gone_.store(std::move(gone));
  }
  for (CameraObserver* observer : observers_) observer->cameras_changed(changed);
  for (const auto& camera : planned.started) camera->start();
  planned.removed.clear();  // so that the plan does not keep these cameras alive
}

void RunningCameras::drop_stopped() {
  const auto before = gone_.load();  // keeps the stopped cameras alive until the lock is released
  if (before->empty()) return;
  const std::lock_guard lock(mutex_);
  List gone = *gone_.load();
  std::erase_if(gone, [](const auto& camera) { return camera->has_stopped(); });
  gone_.store(std::move(gone));
}

void RunningCameras::update_robot_heights() {
  const std::lock_guard lock(mutex_);
  const auto teams = teams_now(config_.load()->teams, referee_.team_names());
  // The names are from the network. JSON escapes them, so that they cannot forge a line of the log.
  log::info("teams: yellow {} {} mm, blue {} {} mm", json_text(Json(teams[0].name)), teams[0].robot_height_mm,
            json_text(Json(teams[1].name)), teams[1].robot_height_mm);
  for (const auto& camera : list())
    camera->change_robot_heights({teams[0].robot_height_mm, teams[1].robot_height_mm});
}

std::string RunningCameras::hanging() const {
  std::vector<CameraProgress> progress;
  for (const auto& camera : list()) progress.push_back(camera->progress());
  for (const auto& camera : *gone_.load()) {
    // A removed camera counts only while its thread is in a stage: a thread that hangs in its driver was
    // abandoned there.
    if (auto gone = camera->progress(); gone.stage) progress.push_back(std::move(gone));
  }
  return find_hanging(progress, steady_ns());
}

std::string RunningCameras::missing() const {
  std::vector<CameraProgress> progress;
  for (const auto& camera : list()) progress.push_back(camera->progress());
  return find_missing(progress);
}

}  // namespace sslv
