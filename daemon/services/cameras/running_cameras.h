// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/multicast.h"
#include "net/referee_listener.h"
#include "services/cameras/cameras.h"
#include "services/cameras/running_camera.h"
#include "services/service.h"
#include "web/view.h"

#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace sslv {

/// The running cameras, one for each camera in the settings. Thread-safe.
class RunningCameras final : public Cameras, public ViewSource {
 public:
  /// All must outlive this. `config`: the settings in effect. `load_table`: see make_context(). No camera
  /// runs before the first change is applied.
  RunningCameras(const Snapshot<Config>& config, MulticastSender& multicast, FieldIntake& field,
                 const RefereeListener& referee, LoadTable load_table);
  /// Stops all cameras in parallel.
  ~RunningCameras() override { ask_to_stop(); }
  /// Starts stopping without waiting.
  void ask_to_stop();

  // Cameras
  std::vector<CameraNow> all() const override;
  CameraNow get(int camera_id) const override;
  std::optional<LentFrame> wait_frame(int camera_id, std::uint64_t newer_than,
                                      std::chrono::milliseconds timeout) override;
  bool change_light(int camera_id, const std::shared_ptr<const Lut>& accepted,
                    std::shared_ptr<const Lut> adapted) override;
  std::map<int, std::shared_ptr<RecordedCamera>> recorded() const override;
  void add_observer(CameraObserver& observer) override { observers_.push_back(&observer); }
  std::string hanging() const override;
  std::string missing() const override;

  // ViewSource
  std::vector<std::uint32_t> camera_ids() const override;
  std::optional<View> wait_view(std::uint32_t camera_id, std::uint64_t newer_than_version,
                                std::chrono::milliseconds timeout) override;

  using List = std::vector<std::shared_ptr<RunningCamera>>;
  /// Sorted by id.
  List list() const;
  /// Null if there is no camera with this id.
  std::shared_ptr<RunningCamera> find(int camera_id) const;

  /// Effects of a change of settings on the cameras.
  Plan plan(const SettingsChange& change);
  /// Releases cameras that were removed from the settings and have stopped. Does not wait: keeps a camera
  /// that hangs in a stage, and hanging() reports it.
  void drop_stopped();
  /// Updates the robot heights of all cameras for the playing teams. Called by the referee's thread.
  void update_robot_heights();

 private:
  using Running = std::map<int, std::shared_ptr<RunningCamera>>;  // by id
  struct Planned;
  void get_ready(Planned& planned);
  void apply(Planned& planned) noexcept;

  const Snapshot<Config>& config_;
  MulticastSender& multicast_;
  FieldIntake& field_;
  const RefereeListener& referee_;
  const LoadTable load_table_;
  std::vector<CameraObserver*> observers_;
  std::mutex mutex_;                                     // held while setups are replaced; guards totals_
  std::map<int, std::shared_ptr<CameraTotals>> totals_;  // by id
  Snapshot<Running> running_{Running{}};
  Snapshot<List> gone_{List{}};  // removed cameras that still run; written with the mutex held
};

}  // namespace sslv
