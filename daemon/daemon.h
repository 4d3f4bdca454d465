// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "calibration_history.h"
#include "calibration_jobs.h"
#include "config.h"
#include "joint_calibration_jobs.h"
#include "monitor.h"
#include "net/other_visions.h"
#include "net/referee_listener.h"
#include "net/vision_sender.h"
#include "running_camera.h"
#include "settings/profiles.h"
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
#include <set>
#include <string>
#include <vector>

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
  /// What new settings need, made without any effect on what runs.
  struct MadeReady {
    std::shared_ptr<const Config> config;
    std::shared_ptr<const Cameras> old_cameras;
    std::vector<CameraSetup> setups;  // in the order of the config's cameras
  };
  /// Throws SettingsError.
  MadeReady make_ready(const Json& settings) const;
  /// Makes everything new settings need; the result puts it into force. Throws SettingsError.
  std::function<void()> prepare(const Json& settings);
  /// Gives every camera the heights of the teams that play now. For the referee's thread.
  void put_robot_heights_into_force();
  /// A camera's finished frame on loan. The camera is held too, because the frame lies in its ring.
  struct HeldFrame {
    std::shared_ptr<RunningCamera> camera;
    FrameRef frame;
  };
  struct NewestFrame {
    std::uint64_t version;
    std::shared_ptr<const HeldFrame> hold;
  };
  std::optional<NewestFrame> hold_frame(std::uint32_t camera_id, std::uint64_t newer_than,
                                        std::chrono::milliseconds timeout);
  std::optional<View> wait_view(std::uint32_t camera_id, std::uint64_t newer_than,
                                std::chrono::milliseconds timeout);
  std::shared_ptr<RunningCamera> camera(std::uint32_t id) const;
  /// Throws HttpError: 404 no such camera, 409 not open or without controls, 503 it does not answer.
  Json answer_of_camera(std::uint32_t camera_id, const std::function<Json(Controls&)>& ask) const;
  Json controls(std::uint32_t camera_id) const;
  Json set_control(std::uint32_t camera_id, const std::string& name, const Json& value,
                   const std::string& who) const;

  // daemon_profiles.cpp
  void add_profiles_to(WebHost& host);
  Profile profile(const std::string& name) const;
  Json profile_json(const std::string& name) const;
  Json apply_profile(const std::string& name, const std::optional<std::vector<std::string>>& paths,
                     std::optional<std::uint64_t> if_revision, const std::string& who);

  // daemon_health.cpp
  void add_health_to(WebHost& host);
  std::vector<std::shared_ptr<RunningCamera>> cameras_now() const;
  HealthInput health_input(const Config& config,
                           const std::vector<std::shared_ptr<RunningCamera>>& cameras) const;
  Json status();
  Json diagnostics() const;
  /// After each of the monitor's looks, in its thread.
  void look_after();
  void find_stale_calibrations();

  // daemon_calibration.cpp
  void add_calibration_to(WebHost& host);
  WaitFrame frame_waiter();
  Json calibration(int camera_id) const;
  Json start_calibration(int camera_id, const Json& request, bool force, const std::string& who);
  Json cancel_calibration(int camera_id);
  Json accept_calibration(int camera_id, bool force, const std::string& who);
  Json reject_calibration(int camera_id);
  Json revert_calibration(int camera_id, bool force, const std::string& who);
  void refuse_while_game_runs() const;
  /// While the game runs, and when a report is not good enough. `what` it is of, with its verb.
  void refuse_acceptance(bool is_good, const std::vector<std::string>& problems,
                         const std::string& what) const;
  struct CalibrationChange {
    int camera_id;
    Json calibration;
    CalibrationHistory::Records records;  // all of the camera's
  };
  /// With a record of it. The settings are those that the change is decided on.
  CalibrationChange new_calibration(const SettingsStore::Version& current, int camera_id,
                                    const CameraCalibration& calibration, Json figures,
                                    const std::string& who) const;
  /// Puts calibrations and the records that go with them onto disk and into force, all or none.
  void put_calibrations_into_force(const std::vector<CalibrationChange>& changes,
                                   const SettingsStore::Version& current, const std::string& what,
                                   const std::string& who);

  // daemon_joint_calibration.cpp
  Json joint_calibration() const;
  Json start_joint_calibration(const Json& request, bool force, const std::string& who);
  Json cancel_joint_calibration();
  Json accept_joint_calibration(bool force, const std::string& who);
  Json reject_joint_calibration();

  const double started_s_;
  SettingsStore store_;
  Profiles profiles_;
  Snapshot<Config> config_;
  MulticastSender multicast_;
  Snapshot<Geometry> geometry_;
  GeometrySender geometry_sender_;
  Snapshot<Cameras> cameras_;
  std::mutex cameras_mutex_;  // held while cameras get new setups, so that no height is lost
  RefereeListener referee_;
  OtherVisions other_visions_;
  mutable std::mutex calibration_mutex_;  // guards the history; held during a whole change of a calibration
  CalibrationHistory calibration_history_;
  CalibrationJobs calibration_jobs_;
  JointCalibrationJobs joint_calibration_jobs_;
  AlertTimes alert_times_;
  Snapshot<std::set<int>> stale_calibrations_{{}};        // ids of the cameras whose field was changed since
  std::shared_ptr<const Config> calibrations_looked_at_;  // of the monitor's thread: with these settings
  Monitor monitor_;
  std::unique_ptr<WebServer> web_;                    // last: it asks all the others
  std::atomic<const WebServer*> listening_{nullptr};  // set once web_ is made: it may ask before
};

}  // namespace sslv
