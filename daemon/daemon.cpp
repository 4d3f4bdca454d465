// SPDX-License-Identifier: Apache-2.0
#include "daemon.h"

#include "base/clock.h"
#include "base/log.h"
#include "base/params_json.h"
#include "cameras.h"
#include "detections_json.h"
#include "net/network_cards.h"
#include "routes.h"
#include "teams.h"
#include "version.h"
#include "vision/label_picture.h"
#include "web/http.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// A change for the log; all of a long one is in the settings' history.
std::string in_short(const Json& patch) {
  constexpr std::size_t kMostBytes = 300;
  std::string text = patch.dump();
  if (text.size() <= kMostBytes) return text;
  std::size_t end = kMostBytes;
  while ((static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;  // whole characters of UTF-8
  return text.substr(0, end) + " ...";
}

Geometry make_geometry(const Config& config) {
  Geometry geometry{config.field, {}, config.ball_models};
  for (std::size_t i = 0; i < config.cameras.size(); ++i) {
    const CameraSettings& camera = config.cameras[i];
    if (camera.calibration) {
      geometry.cameras.push_back({static_cast<std::uint32_t>(camera.id), CameraModel(*camera.calibration)});
    }
  }
  return geometry;
}

std::chrono::duration<double> geometry_interval(const Config& config) {
  return std::chrono::duration<double>(config.network.vision.geometry_interval_s);
}

GroupAddress vision_address(const Config& config) {
  const MulticastSettings& vision = config.network.vision;
  return {vision.group, vision.port, vision.interface};
}

std::optional<GroupAddress> referee_address(const Config& config) {
  const RefereeSettings& referee = config.network.referee;
  if (!referee.enabled) return std::nullopt;
  return GroupAddress{referee.group, referee.port,
                      referee.interface.empty() ? config.network.vision.interface : referee.interface};
}

/// Where settings that come over the network may name files.
std::vector<std::filesystem::path> folders_of(const Daemon::Options& options) {
  std::vector<std::filesystem::path> folders = options.file_folders;
  folders.insert(folders.end(), {std::filesystem::absolute(options.settings_file).parent_path(),
                                 options.state_folder, kInstalledFiles});
  return folders;
}

std::array<double, 2> robot_heights_mm(const Config& config, const RefereeListener& referee) {
  const auto teams = teams_now(config.teams, referee.team_names());
  return {teams[0].robot_height_mm, teams[1].robot_height_mm};
}

}  // namespace

Daemon::Daemon(const Options& options)
    : started_s_(steady_s()),
      file_folders_(folders_of(options)),
      state_folder_(options.state_folder),
      store_(options.settings_file, state_folder_, complete_settings, settings_migrations()),
      passwords_(options.state_folder / Passwords::kFileName),
      access_(passwords_,
              fmt::format("ssl_visiond_{}", store_.current().settings.at("panel").at("port").dump()),
              steady_s),
      profiles_(state_folder_),
      saved_tables_(state_folder_),
      config_(read_config(store_.current().settings)),
      settings_(store_.current().settings),
      multicast_(config_.load()->network.vision, "/network/vision"),
      geometry_(make_geometry(*config_.load())),
      geometry_sender_(multicast_, geometry_, geometry_interval(*config_.load())),
      cameras_(Cameras{}),
      referee_([this] { put_robot_heights_into_force(); }),
      other_visions_([this](const auto& sender) { return multicast_.is_own(sender); }),
      calibration_history_(state_folder_),
      calibration_jobs_(make_calibration_jobs(frame_waiter())),
      joint_calibration_jobs_(make_joint_calibration_jobs(frame_waiter())),
      color_learning_(make_color_learning(frame_waiter())),
      follow_light_(light_hooks()),
      color_margins_(margin_hooks()),
      monitor_(
          options.state_folder, [this] { return cameras_now(); }, [this] { look_after(); }) {
  prepare(store_.current().settings)();
  const auto config = config_.load();
  panel_place_ = {listening_address(config->panel, passwords_.has(Role::kAdmin)), config->panel.port};
  web_ = std::make_unique<WebServer>(
      make_web_host(), routes(), WebOptions{panel_place_.first, panel_place_.second, options.panel_folder});
  listening_ = web_.get();
  const std::lock_guard lock(panel_mutex_);
  panel_may_move_ = true;
}

Daemon::~Daemon() {
  {
    const std::lock_guard lock(panel_mutex_);
    panel_may_move_ = false;
  }
  web_->stop();
  listening_ = nullptr;
  const auto cameras = cameras_.load();
  for (const auto& [id, camera] : *cameras) camera->ask_to_stop();
}

void Daemon::reload() {
  const std::uint64_t before = store_.revision();
  try {
    const auto version =
        store_.reload([this](const Json& next) { return prepare(next, Origin::kAdminFile); });
    if (version.revision == before) {
      settings_since_s_ = unix_time_s();
      log::info("settings file reloaded: nothing has changed");
    } else {
      log::info("settings revision {} saved: settings file reloaded", version.revision);
    }
  } catch (const std::exception& error) {
    log::error("settings file not reloaded, the settings before stay in force: {}", error.what());
  }
}

int Daemon::panel_port() const {
  return web_->port();
}

Daemon::MadeReady Daemon::make_ready(const Json& settings, Origin origin) const {
  if (listening_ != nullptr && origin == Origin::kNetwork) check_files(settings);
  MadeReady ready{std::make_shared<const Config>(read_config(settings)), cameras_.load(), {}};
  const auto& config = ready.config;
  const auto& old_cameras = ready.old_cameras;
  for (std::size_t i = 0; i < config->cameras.size(); ++i) {
    const auto running = old_cameras->find(config->cameras[i].id);
    if (running == old_cameras->end()) {
      ready.setups.push_back(make_setup(*config, i, nullptr, nullptr, load_table()));
    } else {
      ready.setups.push_back(make_setup(*config, i, running->second->settings().get(),
                                        running->second->pipeline().setup().get(), load_table()));
    }
  }
  return ready;
}

LoadTable Daemon::load_table() const {
  const bool is_start = listening_.load() == nullptr;
  return [this, is_start](const std::string& name, const std::string& path,
                          const LabelSet& labels) -> std::shared_ptr<const Lut> {
    try {
      return saved_tables_.load(name, path, labels);
    } catch (const SettingsError& error) {
      if (!is_start) throw;
      log::error("{}", error.what());
      auto lost = *lost_tables_.load();
      lost[name] = error.what();
      lost_tables_.store(std::move(lost));
      return nullptr;
    }
  };
}

std::function<void()> Daemon::prepare(const Json& settings, Origin origin) {
  MadeReady ready = make_ready(settings, origin);
  const auto config = ready.config;
  const auto old_cameras = ready.old_cameras;
  const auto move_panel = prepare_panel(config->panel);
  auto setups = std::make_shared<std::vector<CameraSetup>>(std::move(ready.setups));
  auto controls = std::make_shared<std::vector<ControlChange>>();  // set back unless all this gets into force
  // Last, when all the rest is known to be allowed.
  for (std::size_t i = 0; i < config->cameras.size(); ++i) {
    const auto running = old_cameras->find(config->cameras[i].id);
    const std::string path = "/cameras/" + std::to_string(i) + "/source/controls";
    controls->push_back(running == old_cameras->end()
                            ? ControlChange()
                            : running->second->change_controls(config->cameras[i], path));
  }
  return [this, config, settings, setups, controls, old_cameras, move_panel] {
    move_panel();
    config_.store(*config);
    settings_.store(settings);
    multicast_.configure(config->network.vision, "/network/vision");
    geometry_.store(make_geometry(*config));
    geometry_sender_.restart(geometry_interval(*config));
    other_visions_.listen(vision_address(*config));
    referee_.listen(referee_address(*config));  // before the lock: it waits for a thread that may want it
    const std::lock_guard lock(cameras_mutex_);
    const auto heights_mm = robot_heights_mm(*config, referee_);
    for (CameraSetup& setup : *setups) setup = with_robot_heights(std::move(setup), heights_mm);
    Cameras cameras;
    std::set<int> changed;  // ids of the cameras that do not go on showing what they showed
    for (const auto& [id, camera] : *old_cameras) changed.insert(id);
    for (std::size_t i = 0; i < config->cameras.size(); ++i) {
      const CameraSettings& camera = config->cameras[i];
      const auto running = old_cameras->find(camera.id);
      if (running != old_cameras->end()) {
        if (!running->second->change(camera, std::move((*setups)[i]), (*controls)[i]))
          changed.erase(camera.id);
        cameras[camera.id] = running->second;
      } else {
        auto& totals = camera_totals_[camera.id];
        if (!totals) totals = std::make_shared<CameraTotals>();
        cameras[camera.id] =
            std::make_shared<RunningCamera>(camera, std::move((*setups)[i]), multicast_, totals);
      }
    }
    // Before a camera that goes is missed by its job.
    invalidate(calibration_jobs_, changed);
    invalidate(joint_calibration_jobs_, changed);
    invalidate(color_learning_, changed);
    color_margins_.forget(changed);
    cameras_.store(std::move(cameras));
    settings_since_s_ = unix_time_s();
  };
}

void Daemon::put_robot_heights_into_force() {
  const std::lock_guard lock(cameras_mutex_);
  const auto config = config_.load();
  const auto teams = teams_now(config->teams, referee_.team_names());
  // The names come from the network: as JSON, so that one cannot forge a line of the log.
  log::info("teams: yellow {} {} mm, blue {} {} mm", Json(teams[0].name).dump(), teams[0].robot_height_mm,
            Json(teams[1].name).dump(), teams[1].robot_height_mm);
  const auto cameras = cameras_.load();
  for (const auto& [id, camera] : *cameras) {
    camera->change_robot_heights({teams[0].robot_height_mm, teams[1].robot_height_mm});
  }
}

std::shared_ptr<RunningCamera> Daemon::camera(std::uint32_t id) const {
  const auto cameras = cameras_.load();
  const auto found = cameras->find(static_cast<int>(id));
  return found == cameras->end() ? nullptr : found->second;
}

std::optional<Daemon::NewestFrame> Daemon::hold_frame(std::uint32_t camera_id, std::uint64_t newer_than,
                                                      std::chrono::milliseconds timeout) {
  auto running = camera(camera_id);
  if (!running) return std::nullopt;
  auto newest = running->pipeline().finished().wait_newer(newer_than, timeout);
  if (!newest) return std::nullopt;
  return NewestFrame{newest->version, std::make_shared<const HeldFrame>(
                                          HeldFrame{std::move(running), std::move(newest->value)})};
}

Json Daemon::answer_of_camera(std::uint32_t camera_id, const std::function<Json(Controls&)>& ask) const {
  const auto running = camera(camera_id);
  if (!running) throw HttpError(404, fmt::format("no camera {}", camera_id));
  const auto controls = running->controls();
  if (!controls) {
    const bool is_open = running->health().state == CameraState::kRunning;
    throw HttpError(409, fmt::format("camera {} {}", camera_id, is_open ? "has no controls" : "is not open"));
  }
  try {
    return ask(*controls);
  } catch (const CaptureError& error) {
    throw HttpError(503, error.what());
  }
}

Json Daemon::controls(std::uint32_t camera_id) const {
  return answer_of_camera(camera_id, [&](Controls& controls) {
    Json out = Json::array();
    for (const Control& control : controls.list()) out.push_back(control_json(control));
    return out;
  });
}

Json Daemon::set_control(std::uint32_t camera_id, const std::string& name, const Json& value,
                         const std::string& who) const {
  return answer_of_camera(camera_id, [&](Controls& controls) {
    controls.set(name, value);
    log::info("camera {}: {} set to {} by {}, not saved", camera_id, Json(name).dump(), value.dump(), who);
    return control_json(controls.get(name));
  });
}

std::optional<View> Daemon::wait_view(std::uint32_t camera_id, std::uint64_t newer_than,
                                      std::chrono::milliseconds timeout) {
  const auto newest = hold_frame(camera_id, newer_than, timeout);
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

WebHost Daemon::make_web_host() {
  const auto answer = [](const SettingsStore::Version& version) {
    return Json{{"revision", version.revision}, {"settings", version.settings}};
  };
  WebHost host;
  host.settings = [this, answer] { return answer(store_.current()); };
  host.schema = [] { return settings_schema(); };
  host.field_presets = [] {
    Json presets = Json::array();
    for (const FieldPreset& preset : field_presets()) {
      presets.push_back(
          {{"name", preset.name}, {"description", preset.help}, {"field", params_to_json(preset.size)}});
    }
    return presets;
  };
  host.network_interfaces = [] {
    Json interfaces = Json::array();
    for (const NetworkCard& card : network_cards()) {
      Json addresses = Json::array();
      for (const auto& address : card.addresses) addresses.push_back(address.to_string());
      interfaces.push_back({{"name", card.name},
                            {"addresses", addresses},
                            {"is_up", card.is_up},
                            {"is_loopback", card.is_loopback},
                            {"multicast", card.has_multicast}});
    }
    return interfaces;
  };
  const auto saved = [answer](const SettingsStore::Version& version) {
    Json out = answer(version);
    out["saved"] = true;
    return out;
  };
  host.patch_settings = [this, saved](const Json& patch, std::optional<std::uint64_t> if_revision,
                                      const std::string& who) {
    const auto version =
        store_.patch(patch, {who, if_revision}, [this](const Json& next) { return prepare(next); });
    log::info("settings revision {} saved, changed by {}: {}", version.revision, who, in_short(patch));
    return saved(version);
  };
  host.check_settings = [this](const Json& patch) {
    return store_.check(patch, [this](const Json& next) { make_ready(next); });
  };
  host.settings_history = [this] { return store_.history(); };
  host.undo_settings = [this, saved](std::uint64_t revision, const std::string& who) {
    const auto version = store_.undo(revision, {who}, [this](const Json& next) { return prepare(next); });
    log::info("settings revision {} saved, revision {} taken back by {}", version.revision, revision, who);
    return saved(version);
  };
  host.controls = [this](std::uint32_t id) { return controls(id); };
  host.set_control = [this](std::uint32_t id, const std::string& name, const Json& value,
                            const std::string& who) { return set_control(id, name, value, who); };
  host.sources = [] { return found_cameras_json(); };
  host.camera_ids = [this] {
    std::vector<std::uint32_t> ids;
    const auto cameras = cameras_.load();
    for (const auto& [id, camera] : *cameras) ids.push_back(static_cast<std::uint32_t>(id));
    return ids;
  };
  host.wait_view = [this](std::uint32_t id, std::uint64_t newer_than, std::chrono::milliseconds timeout) {
    return wait_view(id, newer_than, timeout);
  };
  add_access_to(host);
  add_profiles_to(host);
  add_health_to(host);
  add_calibration_to(host);
  add_colors_to(host);
  return host;
}

}  // namespace sslv
