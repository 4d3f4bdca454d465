// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/snapshot.h"
#include "calibration_history.h"
#include "calibration_jobs.h"
#include "color_desk.h"
#include "color_learning.h"
#include "color_margins.h"
#include "colors_json.h"
#include "config.h"
#include "follow_light.h"
#include "joint_calibration_jobs.h"
#include "monitor.h"
#include "net/other_visions.h"
#include "net/referee_listener.h"
#include "net/vision_sender.h"
#include "running_camera.h"
#include "saved_tables.h"
#include "settings/passwords.h"
#include "settings/profiles.h"
#include "settings/store.h"
#include "status.h"
#include "stills.h"
#include "web/access.h"
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
#include <utility>
#include <vector>

namespace sslv {

/// The composition root: owns everything, wires it, and puts changed settings into force.
class Daemon {
 public:
  struct Options {
    std::filesystem::path settings_file, state_folder, panel_folder;
    std::vector<std::filesystem::path> file_folders{};  // besides its own, where the panel may name files
  };

  /// Running when it returns: sockets bound, panel answering, cameras opening. Throws SettingsError.
  explicit Daemon(const Options& options);
  ~Daemon();

  int panel_port() const;
  /// One line for the service manager and the log: cameras, rate, latency, where packets go.
  std::string summary() const;
  /// Reads the settings file anew and puts it into force; logs what came of it.
  void reload();
  /// Why the watchdog must not be fed; empty while all is well.
  std::string hanging() const;

 private:
  using Cameras = std::map<int, std::shared_ptr<RunningCamera>>;  // by id

  WebHost make_web_host();
  void add_access_to(WebHost& host);
  /// Throws SettingsError when settings from the network name files that they must not.
  void check_files(const Json& settings) const;
  /// What lets the panel listen where these settings say; throws SettingsError.
  std::function<void()> prepare_panel(const PanelSettings& panel);
  /// For the monitor's thread: a password may have been set by ssl-visionctl.
  void move_panel_if_needed();
  MatchLock match_lock() const;
  /// The admin's file may name files anywhere.
  enum class Origin { kNetwork, kAdminFile };
  /// What new settings need, made without any effect on what runs.
  struct MadeReady {
    std::shared_ptr<const Config> config;
    std::shared_ptr<const Cameras> old_cameras;
    std::vector<CameraSetup> setups;  // in the order of the config's cameras
  };
  /// Throws SettingsError.
  MadeReady make_ready(const Json& settings, Origin origin = Origin::kNetwork) const;
  /// At start a camera whose table is lost has that of its settings instead, and says so.
  LoadTable load_table() const;
  /// Makes everything new settings need; the result puts it into force. Throws SettingsError.
  std::function<void()> prepare(const Json& settings, Origin origin = Origin::kNetwork);
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
  std::optional<CameraFacts::Margin> least_margin(int camera_id, const LabelSet& labels) const;
  Json status();
  std::string metrics() const;
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

  // daemon_colors.cpp; all that has to do with a desk while colors_mutex_ is held
  void add_colors_to(WebHost& host);
  struct ColorCamera {
    std::shared_ptr<RunningCamera> camera;
    World world;
    ColorDesk& desk;  // with the accepted table on it
  };
  /// Throws HttpError 404.
  ColorCamera color_camera(int camera_id);
  ColorDesk::Save table_saver(int camera_id, const LabelSet& labels, const std::string& who);
  /// Saves in the settings that the camera has this table.
  void put_table_into_force(int camera_id, const std::string& name, const std::string& what,
                            const std::string& who);
  /// Removes saved tables that nothing names any more.
  void tidy_tables();
  Json colors_state(int camera_id);
  LightView light_view(int camera_id, const World& world) const;
  /// A whole table, in the bits of the camera's.
  void take_over(const ColorCamera& at, int camera_id, std::shared_ptr<const Lut> lut,
                 const std::string& what, const std::string& who);
  /// The table in force becomes the accepted one.
  void keep_todays_light(const ColorCamera& at, int camera_id, const std::string& who);
  void take_light_back(const ColorCamera& at, int camera_id, const std::string& who);
  FollowLight::Hooks light_hooks();
  ColorMargins::Hooks margin_hooks();
  TableEdit read_color_command(int camera_id, const Json& json, const std::string& path, const World& world);
  Json edit_colors(int camera_id, const Json& request, const std::string& who);
  Json import_colors(int camera_id, const TableFile& file, const std::string& who);
  /// A still, or the newest picture.
  struct Looked {
    LentPicture picture;
    std::uint32_t frame_number;
    double t_capture_s;
  };
  /// Throws HttpError: 404 no such still, 503 no picture.
  Looked look(int camera_id, std::optional<int> still);
  Json pixels(int camera_id, const PixelWish& wish);
  Json take_still(int camera_id);
  Json start_learning(int camera_id, const Json& json, const std::string& who);
  Json learning_state(int camera_id) const;
  /// Of a finished job; throws HttpError 409.
  std::shared_ptr<const LearningReport> learning_report(int camera_id) const;
  const LearningPicture& learning_picture(const LearningReport& report, int picture) const;
  Json accept_learning(int camera_id, const std::string& who);

  // daemon_joint_calibration.cpp
  Json joint_calibration() const;
  Json start_joint_calibration(const Json& request, bool force, const std::string& who);
  Json cancel_joint_calibration();
  Json accept_joint_calibration(bool force, const std::string& who);
  Json reject_joint_calibration();

  const double started_s_;  // on the steady clock
  const std::vector<std::filesystem::path> file_folders_;
  StateFolder state_folder_;
  SettingsStore store_;
  Passwords passwords_;
  Access access_;
  Profiles profiles_;
  SavedTables saved_tables_;
  Snapshot<Config> config_;
  Snapshot<Json> settings_;  // the tree that config_ was read from
  MulticastSender multicast_;
  Snapshot<Geometry> geometry_;
  GeometrySender geometry_sender_;
  Snapshot<Cameras> cameras_;
  std::mutex cameras_mutex_;  // held while cameras get new setups, so that no height is lost
  std::map<int, std::shared_ptr<CameraTotals>> camera_totals_;  // by id; guarded by it
  std::atomic<double> settings_since_s_{0};
  RefereeListener referee_;
  OtherVisions other_visions_;
  mutable std::mutex calibration_mutex_;  // guards the history; held during a whole change of a calibration
  CalibrationHistory calibration_history_;
  CalibrationJobs calibration_jobs_;
  JointCalibrationJobs joint_calibration_jobs_;
  mutable Snapshot<std::map<std::string, std::string>> lost_tables_{{}};  // at start: name, and why
  std::mutex colors_mutex_;  // guards the desks; held during a whole change of a table
  int tables_since_tidied_ = 0;
  std::map<int, ColorDesk> desks_;  // by camera
  Stills stills_;
  ColorLearning color_learning_;
  FollowLight follow_light_;
  ColorMargins color_margins_;
  AlertTimes alert_times_;
  Snapshot<std::set<int>> stale_calibrations_{{}};        // ids of the cameras whose field was changed since
  std::shared_ptr<const Config> calibrations_looked_at_;  // of the monitor's thread: with these settings
  Monitor monitor_;
  mutable std::atomic<bool> match_lock_opened_ = false;
  std::mutex panel_mutex_;                            // guards the next two
  std::pair<std::string, int> panel_place_;           // address and port that it listens on, as settings say
  bool panel_may_move_ = false;                       // while web_ runs
  std::string panel_problem_;                         // of the monitor\'s thread: why it could not move
  std::unique_ptr<WebServer> web_;                    // last: it asks all the others
  std::atomic<const WebServer*> listening_{nullptr};  // set once web_ is made: it may ask before
};

}  // namespace sslv
