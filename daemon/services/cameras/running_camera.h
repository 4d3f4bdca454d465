// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/recent.h"
#include "base/snapshot.h"
#include "capture/camera_thread.h"
#include "capture/control_queue.h"
#include "config/config.h"
#include "net/vision_sender.h"
#include "pipeline/camera_pipeline.h"
#include "pipeline/field_intake.h"
#include "pipeline/stage_mark.h"
#include "services/cameras/camera_report.h"
#include "services/cameras/camera_setup.h"
#include "services/cameras/camera_totals.h"
#include "services/cameras/recorded_camera.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace sslv {

/// One camera of the service: its thread, its pipeline and the way out to the network. May be used from any
/// thread. Hold it by shared_ptr: viewers of its frames keep it alive.
class RunningCamera {
 public:
  /// Nothing is opened before start(). `multicast` must outlive this. `config`: that the settings are of.
  /// `field`: the camera's way to the tracks. `totals`: of this camera's id. Throws std::system_error when
  /// its thread cannot be had.
  RunningCamera(const CameraSettings& settings, CameraSetup setup, std::shared_ptr<const Config> config,
                MulticastSender& multicast, std::shared_ptr<SightingsQueue> field,
                std::shared_ptr<CameraTotals> totals);
  ~RunningCamera();
  /// Starts capturing; a camera that is not there is tried until it comes.
  void start() noexcept;
  /// Begins what the destructor does and does not wait for it.
  void ask_to_stop();
  /// Nobody waits for its controls any more: that fails, now and later.
  void end_control_calls();
  /// Whether the destructor would not wait: its thread has ended, or hangs in the driver and is left behind
  /// there. One that hangs in a stage has not. Once it was asked to stop.
  bool has_stopped();

  /// What a change of its settings will do.
  struct Change {
    std::shared_ptr<const CameraSettings> settings;
    std::shared_ptr<const Config> config;    // that they are of
    std::optional<NewSetup> setup;           // none: as it is
    std::string path;                        // of its controls in the settings
    bool reopens = false;                    // for another source, a thread, or a control that needs it
    ControlPlan controls{};                  // otherwise, of an open camera
    std::unique_ptr<CameraThread> thread{};  // of get_ready(), when it is reopened
    std::function<ControlQueue::Refusals()> control_outcome{};  // of apply(), when controls are set
  };
  /// Asks the camera nothing. Throws SettingsError, beginning with `path`, for controls that an open camera
  /// is known not to have or take.
  Change plan(const CameraSettings& settings, std::shared_ptr<const Config> config,
              std::optional<NewSetup> setup, std::string path) const;
  /// Makes the stages and the thread that it needs. Throws std::system_error without a thread.
  void get_ready(Change& change);
  /// The next frame uses the new setup, with robots of these heights. Says whether the camera is reopened;
  /// its controls are set when it comes to that.
  bool apply(Change& change, const std::array<double, 2>& robot_height_mm) noexcept;
  /// Waits for that: a line for each control that was not taken, beginning with its path. One that is not
  /// open any more will be opened with them.
  std::vector<std::string> outcome(const Change& change) const;

  /// The next frame has robots of these heights. Not while another thread is in apply().
  void change_robot_heights(const std::array<double, 2>& robot_height_mm);

  /// See Cameras::change_light. Not while another thread is in apply().
  bool change_light(const std::shared_ptr<const Lut>& accepted, std::shared_ptr<const Lut> adapted);

  /// See CameraThread::try_now().
  CameraState try_now() const;

  std::shared_ptr<const CameraSettings> settings() const { return settings_->load(); }
  /// Its counts come from the totals.
  CameraHealth health() const;
  /// Those of the open camera; none while it is not open, or has none. To be asked through their queue.
  std::shared_ptr<Controls> controls() const;
  /// As they were when they were last read; none while the camera is not open.
  std::vector<UnsavedControl> unsaved_controls() const;
  /// What the settings say of its own controls: name -> value.
  Json saved_controls() const;
  const CameraPipeline& pipeline() const { return pipeline_; }
  /// Its last seconds.
  const std::shared_ptr<RecordedCamera>& recorded() const { return recorded_; }
  /// From the frame's arrival to the packet on the socket.
  const RecentDurations& latency() const { return sink_.latency; }
  /// From the middle of the exposure to there.
  const RecentDurations& age() const { return sink_.age; }
  /// Whether its thread goes on.
  CameraProgress progress() const;
  /// Times that apply() reopened it.
  std::uint64_t reopenings() const { return reopenings_; }
  /// When that was last, on the steady clock; 0: never.
  double reopened_s() const { return reopened_s_; }
  /// Lives as long as this.
  const CameraTotals& totals() const { return *totals_; }

 private:
  struct Sink : DetectionSink {
    Sink(MulticastSender& multicast, std::shared_ptr<SightingsQueue> to_field, CameraTotals& camera_totals)
        : sender(multicast), field(std::move(to_field)), totals(camera_totals) {}
    void publish(const FrameInfo& info, const Scene& scene, const RobotList& robots,
                 const BallList& balls) noexcept override;
    void stage_begins(std::size_t stage, std::int64_t now_ns) noexcept override { mark.begin(stage, now_ns); }
    void stage_took(std::size_t stage, std::int64_t duration_ns) noexcept override {
      mark.end();
      totals.stages[stage].add_ns(duration_ns);
    }
    void left_out(std::size_t stage, const Senseless& what) noexcept override {
      totals.left_out[stage].add(what);
    }
    DetectionSender sender;
    const std::shared_ptr<SightingsQueue> field;
    CameraTotals& totals;
    RecentDurations latency, age;
    StageMark mark;
  };
  /// The next frame uses it; `config`: null: as before.
  void use(CameraSetup setup, std::shared_ptr<const Config> config = nullptr);
  /// `controls`: what the camera is opened with besides the settings, unless they say otherwise.
  std::unique_ptr<CameraThread> make_thread(const CameraSettings& settings, const Scene& scene,
                                            ControlValues controls = {});

  /// The camera that was opened last, and its controls: what they remember goes on when it is reopened.
  struct LastOpened {
    std::mutex mutex;
    Json camera;
    std::shared_ptr<Controls> controls;
    Json settings;                             // name -> value that these have, or are being set to
    std::uint64_t begun = 0, handed_over = 0;  // openings are numbered as they begin

    std::uint64_t begin();
    /// `opened`: none: it has no controls. Nothing when a later opening was handed over: a thread that was
    /// left behind may come back at any time.
    void hand_over(std::uint64_t number, const Json& source, const Json& settings_of_controls,
                   const std::shared_ptr<Controls>& opened);
    /// Sets what these say otherwise; nothing when that is nothing.
    std::function<ControlQueue::Refusals()> follow(const Snapshot<CameraSettings>& newest);
  };

  /// Shared with the thread, which opens the camera by the newest settings and may be left behind.
  const std::shared_ptr<Snapshot<CameraSettings>> settings_;
  const std::shared_ptr<LastOpened> last_opened_;
  const std::shared_ptr<CameraTotals> totals_;
  std::atomic<double> reopened_s_{0};
  std::atomic<std::uint64_t> reopenings_{0};
  Sink sink_;
  const std::shared_ptr<RecordedCamera> recorded_ =
      std::make_shared<RecordedCamera>(settings_->load()->id, sink_.sender);
  CameraPipeline pipeline_;
  mutable std::mutex thread_mutex_;  // guards the pointer
  std::unique_ptr<CameraThread> thread_;
};

}  // namespace sslv
