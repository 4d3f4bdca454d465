// SPDX-License-Identifier: Apache-2.0
#include "daemon.h"

#include "config/config.h"
#include "config/version.h"
#include "net/multicast.h"
#include "services/access/access_service.h"
#include "services/access/match_lock.h"
#include "services/access/panel_place.h"
#include "services/calibration/calibration_service.h"
#include "services/calibration/joint_calibration_service.h"
#include "services/cameras/camera_service.h"
#include "services/cameras/still_service.h"
#include "services/colors/color_service.h"
#include "services/colors/learning_service.h"
#include "services/network/network_service.h"
#include "services/settings/profile_service.h"
#include "services/settings/settings_service.h"
#include "services/status/heartbeat.h"
#include "services/status/status_service.h"
#include "web/server.h"
#include "web/websocket.h"

#include <optional>

namespace sslv {
namespace {

/// Where settings that come over the network may name files.
std::vector<std::filesystem::path> file_folders(const Daemon::Options& options) {
  std::vector<std::filesystem::path> folders = options.file_folders;
  folders.insert(folders.end(), {std::filesystem::absolute(options.settings_file).parent_path(),
                                 options.state_folder, kInstalledFiles});
  return folders;
}

}  // namespace

/// In the order in which they are made; each may use those above it. They end in the other order.
struct Daemon::Parts {
  explicit Parts(const Options& options)
      : folder(options.state_folder),
        passwords(options.state_folder / Passwords::kFileName),
        settings(options.settings_file, folder, file_folders(options)),
        profiles(folder),
        saved_tables(folder),
        profile_service(profiles, settings),
        multicast(settings.config().load()->network.vision, "/network/vision"),
        network(settings.config(), multicast),
        match_lock(settings.config(), network.referee()),
        access(settings.config(), passwords, match_lock),
        cameras(settings.config(), multicast, network.referee(),
                [this](const std::string& name, const std::string& path, const LabelSet& labels) {
                  return saved_tables.load(name, path, labels);
                }),
        stills(cameras),
        records(folder, settings),
        calibration(settings.config(), settings, cameras, records, match_lock, network.referee()),
        joint_calibration(settings.config(), settings, cameras, records, match_lock, network.referee()),
        tables(cameras, settings, saved_tables, profiles),
        colors(cameras, stills, tables, saved_tables, network.referee()),
        learning(cameras, stills, tables, colors),
        status(options.state_folder, cameras, counters, [this] { return network.missing(); }) {
    // In the order in which their checks are shown.
    const std::vector<Service*> services{&cameras, &stills,          &calibration, &joint_calibration, &colors,
                                         &learning, &network,        &status,      &settings,
                                         &profile_service, &access};
    status.set_services(services);
    for (Service* service : services) {
      for (Route& route : service->routes()) routes.push_back(std::move(route));
    }
    for (Route& route : websocket_routes()) routes.push_back(std::move(route));
    network.on_new_team_names([this] { cameras.update_robot_heights(); });

    const PanelSettings& panel = settings.config().load()->panel;
    const std::string address = listening_address(panel, passwords.has(Role::kAdmin));
    // Cameras come last: preparing them may already set controls of theirs.
    settings.start({&network, &colors, &cameras});
    web.emplace(WebParts{access, cameras, {&status}, routes}, WebOptions{address, panel.port, options.panel_folder},
                counters);
    panel_place.emplace(settings.config(), passwords, *web);
    settings.use({&*panel_place, &network, &colors, &cameras});

    std::vector<Service*> beating = services;
    beating.push_back(&*panel_place);
    heartbeat.emplace(beating, [this] { summary.store(cameras.summary() + " -> " + network.summary()); });
    summary.store(cameras.summary() + " -> " + network.summary());
  }

  ~Parts() {
    heartbeat.reset();
    if (web) web->stop();      // from here on nobody asks for a change
    network.stop_listening();  // nor gives cameras other heights
  }

  StateFolder folder;
  Passwords passwords;
  SettingsService settings;
  Profiles profiles;
  SavedTables saved_tables;
  ProfileService profile_service;
  MulticastSender multicast;
  NetworkService network;
  MatchLock match_lock;
  AccessService access;
  CameraService cameras;
  StillService stills;
  CalibrationRecords records;
  CalibrationService calibration;
  JointCalibrationService joint_calibration;
  ColorTables tables;
  ColorService colors;
  LearningService learning;
  WebCounters counters;
  StatusService status;
  std::vector<Route> routes;
  std::optional<WebServer> web;
  std::optional<PanelPlace> panel_place;
  Snapshot<std::string> summary;
  std::optional<Heartbeat> heartbeat;
};

Daemon::Daemon(const Options& options) : parts_(std::make_unique<Parts>(options)) {}

Daemon::~Daemon() = default;

int Daemon::panel_port() const {
  return parts_->web->port();
}

std::string Daemon::summary() const {
  return *parts_->summary.load();
}

void Daemon::reload() {
  parts_->settings.reload();
}

std::string Daemon::hanging() const {
  return parts_->cameras.hanging();
}

const std::vector<Route>& Daemon::routes() const {
  return parts_->routes;
}

}  // namespace sslv
