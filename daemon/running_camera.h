// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/recent.h"
#include "base/snapshot.h"
#include "camera_totals.h"
#include "capture/camera_thread.h"
#include "config.h"
#include "control_change.h"
#include "net/vision_sender.h"
#include "pipeline/camera_pipeline.h"

#include <array>
#include <memory>
#include <mutex>
#include <string>

namespace sslv {

/// One camera of the daemon: its thread, its pipeline and the way out to the network. May be used from any
/// thread. Hold it by shared_ptr: viewers of its frames keep it alive.
class RunningCamera {
 public:
  /// Starts capturing at once; a camera that is not there is tried until it comes. `multicast` must outlive
  /// this. `totals`: of this camera's id.
  RunningCamera(const CameraSettings& settings, CameraSetup setup, MulticastSender& multicast,
                std::shared_ptr<CameraTotals> totals);
  ~RunningCamera();
  /// Begins what the destructor does and does not wait for it.
  void ask_to_stop();

  /// Sets what changed among the camera's own controls, before the settings that say so are in force. Throws
  /// SettingsError, beginning with `path`, for what an open camera refuses; one that is not open is not
  /// asked.
  ControlChange change_controls(const CameraSettings& settings, const std::string& path) const;

  /// The next frame uses the new setup. The camera is closed and opened anew only when its source or thread
  /// settings have changed, other than in `controls`; says whether it was.
  bool change(const CameraSettings& settings, CameraSetup setup, ControlChange& controls);

  /// The next frame has robots of these heights. Not while another thread is in change().
  void change_robot_heights(const std::array<double, 2>& robot_height_mm);

  /// The next frame uses this table, which is the accepted one in today's light. False when that is no longer
  /// the accepted one. Not while another thread is in change().
  bool change_light(const std::shared_ptr<const Lut>& accepted, std::shared_ptr<const Lut> in_todays_light);

  std::shared_ptr<const CameraSettings> settings() const { return settings_->load(); }
  /// Its counts are those of the totals.
  CameraHealth health() const;
  /// Those of the open camera; none while it is not open, or has none.
  std::shared_ptr<Controls> controls() const;
  const CameraPipeline& pipeline() const { return pipeline_; }
  /// From the picture's arrival to the packet on the socket.
  const RecentDurations& latency() const { return sink_.latency; }
  /// From the exposure's middle to there.
  const RecentDurations& age() const { return sink_.age; }
  /// Lives as long as this.
  const CameraTotals& totals() const { return *totals_; }

 private:
  struct Sink : DetectionSink {
    Sink(MulticastSender& multicast, CameraTotals& camera_totals)
        : sender(multicast), totals(camera_totals) {}
    void publish(const FrameInfo& info, const RobotList& robots, const BallList& balls) noexcept override;
    void stage_took(std::size_t stage, std::int64_t duration_ns) noexcept override {
      totals.stages[stage].add_ns(duration_ns);
    }
    DetectionSender sender;
    CameraTotals& totals;
    RecentDurations latency, age;
  };
  /// In the place of the one that is there, without waiting for its end.
  void start_thread();

  /// Shared with the thread, which opens the camera by what is in force then and may be left behind.
  const std::shared_ptr<Snapshot<CameraSettings>> settings_;
  const std::shared_ptr<CameraTotals> totals_;
  Sink sink_;
  CameraPipeline pipeline_;
  mutable std::mutex thread_mutex_;  // guards the pointer
  std::unique_ptr<CameraThread> thread_;
};

/// A setup for the camera at place `i` of the list. The pipeline of `previous`, with what its stages
/// remember, is kept when the stack is the same, and its colour table when the colours are. Throws
/// SettingsError.
CameraSetup make_setup(const Config& config, std::size_t i, const CameraSettings* previous_settings,
                       const CameraSetup* previous, const LoadTable& load_table);

/// The same setup with robots of these heights.
CameraSetup with_robot_heights(CameraSetup setup, const std::array<double, 2>& robot_height_mm);

}  // namespace sslv
