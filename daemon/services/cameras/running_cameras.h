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

/// The cameras that run, one for each of the settings. May be used from any thread.
class RunningCameras final : public Cameras, public ViewSource {
 public:
  /// All must outlive this. `config`: in effect. `load_table`: see make_context(). No camera runs before the
  /// first change is applied.
  RunningCameras(const Snapshot<Config>& config, MulticastSender& multicast, FieldIntake& field,
                 const RefereeListener& referee, LoadTable load_table);
  /// Stops all cameras at once.
  ~RunningCameras() override { ask_to_stop(); }
  /// Begins that and does not wait for it.
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
  /// In the order of their ids.
  List list() const;
  /// Null when there is none with this id.
  std::shared_ptr<RunningCamera> find(int camera_id) const;

  /// What a change of settings does to them.
  Plan plan(const SettingsChange& change);
  /// Lets go of cameras that were taken out of the settings and have stopped. Waits for none: one that hangs
  /// in a stage stays, and is hanging().
  void drop_stopped();
  /// Gives every camera the heights of the teams that play now. For the referee's thread.
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
  std::mutex mutex_;                                     // held while cameras get new setups; guards the next
  std::map<int, std::shared_ptr<CameraTotals>> totals_;  // by id
  Snapshot<Running> running_{Running{}};
  Snapshot<List> gone_{List{}};  // that still have to end; written with the mutex held
};

}  // namespace sslv
