// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration_json.h"
#include "image/image.h"
#include "vision/detections.h"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>

namespace sslv {

enum class CalibrationState : std::uint8_t { kIdle, kCollecting, kSolving, kDone, kFailed, kCancelled };
const char* name_of(CalibrationState state);
bool is_running(CalibrationState state);

/// Adds a camera's frame to the mean. Throws CaptureError when it has no colours or another size.
void add_frame(MeanPicture& mean, const ImageView& frame);
[[noreturn]] void throw_no_picture(std::chrono::milliseconds silence);

/// Calibrates cameras while they go on working: in one thread of low priority, one camera after the other, at
/// most one job for each. May be used from any thread.
class CalibrationJobs {
 public:
  /// A camera's finished frame, on loan: let go soon.
  struct LentFrame {
    std::uint64_t version = 0;
    std::shared_ptr<const void> hold;
    ImageView image;
    double t_capture_s = 0;
    std::span<const Robot> robots{};
  };
  /// The newest frame once its version is newer than the given one (0: any); nothing after the timeout.
  using WaitFrame = std::function<std::optional<LentFrame>(int camera_id, std::uint64_t newer_than,
                                                           std::chrono::milliseconds timeout)>;

  struct Order {
    CalibrationRequest request;
    FieldSize field;
    std::optional<CameraCalibration> previous;
    std::string who;  // the client's address
    double time_s = 0;
  };
  /// What is known of a camera's newest job.
  struct Job {
    CalibrationState state = CalibrationState::kIdle;
    std::shared_ptr<const Order> order;               // none when idle
    int frames = 0;                                   // taken so far
    std::shared_ptr<const CalibrationReport> report;  // once done
    std::string problem;                              // why it failed
  };

  /// `silence`: a camera that delivers nothing for so long fails.
  explicit CalibrationJobs(WaitFrame wait_frame,
                           std::chrono::milliseconds silence = std::chrono::seconds(10));
  /// Ends what is running.
  ~CalibrationJobs();

  Job job(int camera_id) const;
  /// False when one is running already.
  bool start(int camera_id, Order order);
  /// False when none is running.
  bool cancel(int camera_id);
  /// Forgets a job that has ended; false when it is another than the one with this report.
  bool forget(int camera_id, const CalibrationReport* report);
  /// The camera shows something else from now on: its job fails, whether it runs or has a report.
  void invalidate(int camera_id);

 private:
  struct Running {
    int camera_id;
    Job job;
    std::stop_source stop;
  };
  using RunningPtr = std::shared_ptr<Running>;

  void serve(const std::stop_token& ending);
  void work_on(const RunningPtr& running);
  /// The mean of fresh frames; nothing when it was stopped. Throws CaptureError.
  std::optional<MeanPicture> collect(const RunningPtr& running);
  /// Changes a job unless it was stopped.
  template <class Change>
  void change(const RunningPtr& running, Change change_job);

  const WaitFrame wait_frame_;
  const std::chrono::milliseconds silence_;
  mutable std::mutex mutex_;  // guards what follows, and all jobs
  std::condition_variable_any ordered_;
  std::deque<RunningPtr> orders_;
  std::map<int, RunningPtr> newest_;  // by camera
  std::jthread thread_;               // last: it uses all the others
};

}  // namespace sslv
