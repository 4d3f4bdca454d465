// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "config.h"
#include "net/other_visions.h"
#include "net/referee_listener.h"
#include "net/vision_sender.h"
#include "running_camera.h"
#include "settings/store.h"
#include "status.h"
#include "web/server.h"

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace sslv {

/// The composition root: owns everything, wires it, and puts changed settings into force.
class Daemon {
 public:
  struct Options {
    std::filesystem::path settings_file, state_folder, panel_folder;
  };

  /// Running when it returns: sockets bound, panel answering, cameras opening. Throws SettingsError.
  explicit Daemon(const Options& options);
  ~Daemon();

  int panel_port() const;
  /// One line for the service manager and the log: cameras, rate, latency, where packets go.
  std::string summary() const;

 private:
  using Cameras = std::map<int, std::shared_ptr<RunningCamera>>;  // by id

  WebHost make_web_host();
  /// Makes everything new settings need; the result puts it into force. Throws SettingsError.
  std::function<void()> prepare(const Json& settings);
  /// Gives every camera the heights of the teams that play now. For the referee's thread.
  void put_robot_heights_into_force();
  Json status() const;
  StatusInput status_input(const Config& config) const;
  std::optional<View> wait_view(std::uint32_t camera_id, std::uint64_t newer_than,
                                std::chrono::milliseconds timeout);
  std::shared_ptr<RunningCamera> camera(std::uint32_t id) const;

  const double started_s_;
  SettingsStore store_;
  Snapshot<Config> config_;
  MulticastSender multicast_;
  Snapshot<Geometry> geometry_;
  GeometrySender geometry_sender_;
  Snapshot<Cameras> cameras_;
  std::mutex cameras_mutex_;  // held while cameras get new setups, so that no height is lost
  RefereeListener referee_;
  OtherVisions other_visions_;
  std::unique_ptr<WebServer> web_;                    // last: it asks all the others
  std::atomic<const WebServer*> listening_{nullptr};  // set once web_ is made: it may ask before
};

}  // namespace sslv
