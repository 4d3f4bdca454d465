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

/// One camera of the service: its thread, its pipeline and its output to the network. Thread-safe. Hold it by
/// shared_ptr: viewers of its frames keep it alive.
class RunningCamera {
 public:
  /// Opens nothing before start(). `multicast` must outlive this. `config`: contains the settings. `field`:
  /// passes the camera's detections to the tracking. `totals`: the totals of this camera's id. Throws
  /// std::system_error if its thread cannot be created.
  RunningCamera(const CameraSettings& settings, CameraSetup setup, std::shared_ptr<const Config> config,
                MulticastSender& multicast, std::shared_ptr<SightingsQueue> field,
                std::shared_ptr<CameraTotals> totals);
  ~RunningCamera();
  /// Starts capturing; a missing camera is retried until it appears.
  void start() noexcept;
  /// Starts stopping without waiting; the destructor waits.
  void ask_to_stop();
  /// Makes all current and later calls that wait for its controls fail.
  void end_control_calls();
  /// Whether the destructor can run without waiting: the thread has ended, or hangs in the driver and was
  /// abandoned there. A thread that hangs in a stage has not stopped. Call it after ask_to_stop().
  bool has_stopped();

  /// Effects of a change of its settings.
  struct Change {
    std::shared_ptr<const CameraSettings> settings;
    std::shared_ptr<const Config> config;    // config that contains `settings`
    std::optional<NewSetup> setup;           // none: unchanged
    std::string path;                        // path of the camera's controls in the settings
    bool reopens = false;                    // source, thread or a control require reopening
    ControlPlan controls{};                  // for an open camera that is not reopened
    std::unique_ptr<CameraThread> thread{};  // made by get_ready() if the camera is reopened
    std::function<ControlQueue::Refusals()> control_outcome{};  // set by apply() if controls are set
  };
  /// Does not query the camera. Throws SettingsError with a message that begins with `path` for controls that
  /// the open camera is known to lack or refuse.
  Change plan(const CameraSettings& settings, std::shared_ptr<const Config> config,
              std::optional<NewSetup> setup, std::string path) const;
  /// Creates the stages and the thread that the change needs. Throws std::system_error if no thread can be
  /// created.
  void get_ready(Change& change);
  /// Applies the change; the next frame uses the new setup, with these robot heights. Returns whether the
  /// camera is reopened. The controls are set later: see outcome().
  bool apply(Change& change, const std::array<double, 2>& robot_height_mm) noexcept;
  /// Waits until the controls are set. Returns a line for each control that the camera refused, beginning
  /// with the control's path. If the camera is no longer open, the controls are set when it is opened again.
  std::vector<std::string> outcome(const Change& change) const;

  /// The next frame uses these robot heights. Must not be called while another thread is in apply().
  void change_robot_heights(const std::array<double, 2>& robot_height_mm);

  /// See Cameras::change_light(). Must not be called while another thread is in apply().
  bool change_light(const std::shared_ptr<const Lut>& accepted, std::shared_ptr<const Lut> adapted);

  /// See CameraThread::try_now().
  CameraState try_now() const;

  std::shared_ptr<const CameraSettings> settings() const { return settings_->load(); }
  /// The counts are the totals of this camera's id (CameraTotals).
  CameraHealth health() const;
  /// Controls of the open camera; null while it is not open, or has none. Use them through their queue.
  std::shared_ptr<Controls> controls() const;
  /// The unsaved controls, as last read; empty while the camera is not open.
  std::vector<UnsavedControl> unsaved_controls() const;
  /// The saved values of its own controls: name -> value.
  Json saved_controls() const;
  const CameraPipeline& pipeline() const { return pipeline_; }
  /// The recorder of its last seconds.
  const std::shared_ptr<RecordedCamera>& recorded() const { return recorded_; }
  /// From the frame's arrival to the packet on the socket.
  const RecentDurations& latency() const { return sink_.latency; }
  /// From the middle of the exposure to the packet on the socket.
  const RecentDurations& age() const { return sink_.age; }
  /// Progress of its thread.
  CameraProgress progress() const;
  /// Number of times apply() reopened it.
  std::uint64_t reopenings() const { return reopenings_; }
  /// Time of the last reopening on the steady clock, s; 0: never.
  double reopened_s() const { return reopened_s_; }
  /// Valid as long as this object.
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
    void left_out(std::size_t stage, const InvalidCounts& what) noexcept override {
      totals.left_out[stage].add(what);
    }
    DetectionSender sender;
    const std::shared_ptr<SightingsQueue> field;
    CameraTotals& totals;
    RecentDurations latency, age;
    StageMark mark;
  };
  /// The next frame uses `setup`. `config`: null if it is unchanged.
  void use(CameraSetup setup, std::shared_ptr<const Config> config = nullptr);
  /// `controls`: values at opening of controls that the settings do not name.
  std::unique_ptr<CameraThread> make_thread(const CameraSettings& settings, const Scene& scene,
                                            ControlValues controls = {});

  /// The camera that was opened last, and its controls. When the same camera is reopened, the new controls
  /// inherit the known state of the previous controls: see ControlQueue::begin().
  struct LastOpened {
    std::mutex mutex;
    Json camera;
    std::shared_ptr<Controls> controls;
    Json settings;                             // name -> value last set or being set
    std::uint64_t begun = 0, handed_over = 0;  // openings are numbered as they begin

    std::uint64_t begin();
    /// `opened`: null if the camera has no controls. Does nothing if a later opening was handed over already:
    /// an abandoned thread may return at any time.
    void hand_over(std::uint64_t number, const Json& source, const Json& settings_of_controls,
                   const std::shared_ptr<Controls>& opened);
    /// Sets the controls whose settings have changed; returns an empty function if no setting has changed.
    std::function<ControlQueue::Refusals()> follow(const Snapshot<CameraSettings>& newest);
  };

  /// Shared with the thread, which opens the camera with the newest settings and may be abandoned.
  const std::shared_ptr<Snapshot<CameraSettings>> settings_;
  const std::shared_ptr<LastOpened> last_opened_;
  const std::shared_ptr<CameraTotals> totals_;
  std::atomic<double> reopened_s_{0};
  std::atomic<std::uint64_t> reopenings_{0};
  Sink sink_;
  const std::shared_ptr<RecordedCamera> recorded_ =
      std::make_shared<RecordedCamera>(settings_->load()->id, sink_.sender);
  CameraPipeline pipeline_;
  mutable std::mutex thread_mutex_;  // guards thread_
  std::unique_ptr<CameraThread> thread_;
};

}  // namespace sslv
