// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calibration/calibrate_jointly.h"
#include "calibration_jobs.h"
#include "joint_calibration_json.h"

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace sslv {

/// Calibrates several cameras together while they go on working: in a thread of low priority, one job at a
/// time. May be used from any thread.
class JointCalibrationJob {
 public:
  struct Camera {
    int id;
    CameraCalibration calibration;  // in force
  };
  struct Order {
    JointCalibrationRequest request;
    std::vector<Camera> cameras;
    FieldSize field;
    std::string who;  // the client's address
    double time_s = 0;
  };
  /// What is known of the newest job.
  struct Job {
    CalibrationState state = CalibrationState::kIdle;
    std::shared_ptr<const Order> order;         // none when idle
    int frames = 0;                             // taken so far of each camera
    int ties = 0;                               // places where two cameras saw the same robot
    std::shared_ptr<const JointReport> report;  // once done
    std::string problem;                        // why it failed
  };

  /// `silence`: with a camera that delivers nothing for so long it fails.
  explicit JointCalibrationJob(CalibrationJobs::WaitFrame wait_frame,
                               std::chrono::milliseconds silence = std::chrono::seconds(10));
  /// Ends what is running.
  ~JointCalibrationJob();

  Job job() const;
  /// False when one is running already.
  bool start(Order order);
  /// False when none is running.
  bool cancel();
  /// Forgets a job that has ended; false when it is another than the one with this report.
  bool forget(const JointReport* report);

 private:
  struct Running {
    Job job;
    std::stop_source stop;
  };
  using RunningPtr = std::shared_ptr<Running>;

  void serve(const std::stop_token& ending);
  void work_on(const RunningPtr& running);
  /// Pictures and ties of fresh frames; nothing when it was stopped. Throws CaptureError.
  std::optional<JointTask> collect(const RunningPtr& running);
  /// Changes a job unless it was cancelled.
  template <class Change>
  void change(const RunningPtr& running, Change change_job);

  const CalibrationJobs::WaitFrame wait_frame_;
  const std::chrono::milliseconds silence_;
  mutable std::mutex mutex_;  // guards what follows, and all jobs
  std::condition_variable_any ordered_;
  RunningPtr newest_, waiting_;  // the newest job; and it again until the thread takes it
  std::jthread thread_;          // last: it uses all the others
};

}  // namespace sslv
