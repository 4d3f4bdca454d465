// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "net/multicast.h"
#include "net/referee_listener.h"
#include "services/cameras/cameras.h"
#include "services/cameras/running_camera.h"
#include "services/service.h"
#include "web/view.h"

#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace sslv {

/// The cameras that run, one for each of the settings. May be used from any thread.
class RunningCameras final : public Cameras, public ViewSource {
 public:
  /// All must outlive this. `config`: in effect. `load_table`: see make_context(). No camera runs before the
  /// first change is committed.
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

  /// In the order of their ids.
  std::vector<std::shared_ptr<RunningCamera>> list() const;
  /// Null when there is none with this id.
  std::shared_ptr<RunningCamera> find(int camera_id) const;

  /// See Service::prepare().
  Commit prepare(const SettingsChange& change);
  /// Those that were taken out of the settings since the last call. To let go of one waits until its thread
  /// has ended.
  std::vector<std::shared_ptr<RunningCamera>> take_gone();
  /// Gives every camera the heights of the teams that play now. For the referee's thread.
  void update_robot_heights();

 private:
  using Running = std::map<int, std::shared_ptr<RunningCamera>>;  // by id
  struct Prepared;

  void commit(Prepared& prepared) noexcept;

  const Snapshot<Config>& config_;
  MulticastSender& multicast_;
  FieldIntake& field_;
  const RefereeListener& referee_;
  const LoadTable load_table_;
  std::vector<CameraObserver*> observers_;
  std::mutex mutex_;  // held while cameras get new setups; guards the next two
  std::map<int, std::shared_ptr<CameraTotals>> totals_;  // by id
  std::list<std::shared_ptr<RunningCamera>> gone_;       // that still have to end
  Snapshot<Running> running_{Running{}};
};

}  // namespace sslv
