// SPDX-License-Identifier: Apache-2.0
#include "daemon.h"

#include "base/background.h"
#include "config/config.h"
#include "config/stages.h"
#include "config/version.h"
#include "net/multicast.h"
#include "services/access/access_service.h"
#include "services/access/match_lock.h"
#include "services/access/panel_place.h"
#include "services/backup/backup_service.h"
#include "services/calibration/calibration_service.h"
#include "services/calibration/joint_calibration_service.h"
#include "services/cameras/camera_service.h"
#include "services/cameras/still_service.h"
#include "services/colors/color_service.h"
#include "services/colors/learning_service.h"
#include "services/field/field_service.h"
#include "services/network/network_service.h"
#include "services/recording/clip_service.h"
#include "services/recording/recording_service.h"
#include "services/recording/replay_service.h"
#include "services/settings/profile_service.h"
#include "services/settings/settings_service.h"
#include "services/sources/source_service.h"
#include "services/status/heartbeat.h"
#include "services/status/status_service.h"
#include "services/verdict/verdict_service.h"
#include "web/websocket.h"

#include <optional>

namespace sslv {
namespace {

/// Folders in which settings from the network may name files.
std::vector<std::filesystem::path> file_folders(const Daemon::Options& options) {
  std::vector<std::filesystem::path> folders = options.file_folders;
  folders.insert(folders.end(), {std::filesystem::absolute(options.settings_file).parent_path(),
                                 options.state_folder, kInstalledFiles});
  return folders;
}

/// The contents of the state folder, except the settings.
struct Kept {
  explicit Kept(const std::filesystem::path& path)
      : folder(path), passwords(path / Passwords::kFileName), profiles(folder), tables(folder) {}

  StateFolder folder;
  Passwords passwords;
  Profiles profiles;
  SavedTables tables;
};

struct NetworkParts {
  explicit NetworkParts(SettingsService& settings)
      : multicast(settings.config().load()->network.vision, "/network/vision"),
        service(settings.config(), multicast),
        match_lock(settings.config(), service.referee()) {}

  MulticastSender multicast;
  NetworkService service;
  MatchLock match_lock;
};

struct FieldParts {
  FieldParts(Kept& kept, SettingsService& settings)
      : service(settings.config(), intake, settings, kept.folder, for_log) {}

  FieldIntake intake;
  TracksForLog for_log;
  FieldService service;
};

struct CameraParts {
  CameraParts(SettingsService& settings, NetworkParts& network, FieldParts& field, const SavedTables& tables)
      : running(settings.config(), network.multicast, field.intake, network.service.referee(),
                [&tables](const std::string& name, const std::string& path, const LabelSet& labels) {
                  return tables.load(name, path, labels);
                }),
        service(running),
        stills(running) {}

  RunningCameras running;
  CameraService service;
  StillService stills;
};

struct CalibrationParts {
  CalibrationParts(Kept& kept, SettingsService& settings, NetworkParts& network, CameraParts& cameras)
      : records(kept.folder, settings),
        service(settings.config(), settings, cameras.running, records, network.match_lock,
                network.service.referee()),
        joint(settings.config(), settings, cameras.running, records, network.match_lock,
              network.service.referee()) {}

  CalibrationRecords records;
  CalibrationService service;
  JointCalibrationService joint;
};

struct ColorParts {
  ColorParts(Kept& kept, SettingsService& settings, NetworkParts& network, CameraParts& cameras)
      : tables(cameras.running, settings, kept.tables, kept.profiles),
        service(cameras.running, cameras.stills, tables, kept.tables, network.service.referee()),
        learning(cameras.running, cameras.stills, tables, service) {}

  ColorTables tables;
  ColorService service;
  LearningService learning;
};

struct RecordingParts {
  RecordingParts(Kept& kept, SettingsService& settings, NetworkParts& network, FieldParts& field,
                 CameraParts& cameras, ColorParts& colors, std::vector<KeptFile> left)
      : files(kept.folder.path() / RecordingFiles::kFolderName),
        service(
            settings.config(), files, network.service.referee(),
            [&network, &field](const auto& sender) {
              return network.multicast.is_own(sender) || field.service.is_own(sender);
            },
            field.for_log),
        clips(settings.config(), files, cameras.running, network.service.referee(), std::move(left)),
        replay(settings.config(), files, cameras.running,
               [&colors](int camera_id) { return colors.learning.learnt_table(camera_id); }) {}

  RecordingFiles files;
  RecordingService service;
  ClipService clips;
  ReplayService replay;
};

}  // namespace

/// The services in the order of construction: each may use the services above it. They are destroyed in the
/// reverse order, also if start() throws.
struct Daemon::Parts {
  explicit Parts(Options options)
      : kept(options.state_folder),
        settings(options.settings_file, kept.folder, file_folders(options)),
        profiles(kept.profiles, settings),
        network(settings),
        access(settings.config(), kept.passwords, network.match_lock, panel_reach),
        panel(settings.config(), kept.passwords, panel_reach),
        field(kept, settings),
        cameras(settings, network, field, kept.tables),
        calibration(kept, settings, network, cameras),
        colors(kept, settings, network, cameras),
        sources(kept.folder, settings, cameras.running, file_folders(options)),
        verdict(settings.config(), cameras.running, network.service.referee()),
        recording(kept, settings, network, field, cameras, colors, std::move(options.left)),
        backup(kept.folder, settings, kept.passwords, kept.profiles, {&kept.tables, &calibration.records}),
        status(options.state_folder, cameras.running, web_counters,
               [this] { return network.service.missing(); }) {
    status.set_services(services);
    for (Service* service : services) {
      for (Route& route : service->routes()) routes.push_back(std::move(route));
    }
    for (Route& route : websocket_routes()) routes.push_back(std::move(route));
    network.service.on_new_team_names([this] { cameras.running.update_robot_heights(); });
    network.service.on_other_vision(
        [this](const VisionMessage& message, const std::string& address, bool is_named, double now_s) {
          field.service.hear(message, address, is_named, now_s);
        });
  }

  void start(const std::filesystem::path& panel_folder) {
    settings.start(services);
    panel.listen(WebParts{access, cameras.running, {&status, &field.service}, routes}, panel_folder,
                 web_counters);
    heartbeat.emplace(services,
                      [this] { return cameras.service.summary() + " -> " + network.service.summary(); });
  }

  /// Asks all services to stop before anything waits for the first one, so that the waiting times do not add
  /// up.
  void ask_to_stop() {
    stop_yielding();
    ask_stages_to_stop();
    if (heartbeat) heartbeat->ask_to_stop();
    for (Service* service : services) service->ask_to_stop();
  }

  ~Parts() {
    ask_to_stop();
    heartbeat.reset();
    panel.stop();                      // no client can request a change from here on
    network.service.stop_listening();  // and no message can change robot heights
  }

  Kept kept;
  SettingsService settings;
  ProfileService profiles;
  NetworkParts network;
  Snapshot<PanelReach> panel_reach{PanelReach{}};
  AccessService access;
  PanelPlace panel;
  FieldParts field;
  CameraParts cameras;
  CalibrationParts calibration;
  ColorParts colors;
  SourceService sources;
  VerdictService verdict;
  RecordingParts recording;
  BackupService backup;
  WebCounters web_counters;
  StatusService status;
  /// All services. Only services in this list plan changes of settings, provide routes, are called every
  /// second and are asked to stop. They are called in this order, and their checks are shown in this order.
  const std::vector<Service*> services{&verdict,
                                       &field.service,
                                       &cameras.service,
                                       &cameras.stills,
                                       &sources,
                                       &calibration.service,
                                       &calibration.joint,
                                       &colors.service,
                                       &colors.learning,
                                       &network.service,
                                       &recording.service,
                                       &recording.clips,
                                       &recording.replay,
                                       &status,
                                       &settings,
                                       &profiles,
                                       &backup,
                                       &access,
                                       &panel};
  std::vector<Route> routes;
  std::optional<Heartbeat> heartbeat;
};

Daemon::Daemon(Options options) {
  const std::filesystem::path panel_folder = options.panel_folder;
  parts_ = std::make_unique<Parts>(std::move(options));
  parts_->start(panel_folder);
}

Daemon::~Daemon() = default;

int Daemon::panel_port() const {
  return parts_->panel.port();
}

std::string Daemon::summary() const {
  return parts_->heartbeat->summary();
}

void Daemon::reload() {
  parts_->settings.reload();
}

void Daemon::ask_to_stop() {
  parts_->ask_to_stop();
}

std::string Daemon::hanging() const {
  return parts_->cameras.running.hanging();
}

const std::vector<Route>& Daemon::routes() const {
  return parts_->routes;
}

}  // namespace sslv
