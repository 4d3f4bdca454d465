// SPDX-License-Identifier: Apache-2.0
#include "joint_calibration_job.h"

#include "base/background.h"
#include "base/log.h"
#include "capture/source.h"
#include "tie_collector.h"

#include <algorithm>
#include <exception>
#include <utility>

#include <fmt/format.h>

namespace sslv {

JointCalibrationJob::JointCalibrationJob(CalibrationJobs::WaitFrame wait_frame,
                                         std::chrono::milliseconds silence)
    : wait_frame_(std::move(wait_frame)),
      silence_(silence),
      thread_([this](const std::stop_token& ending) { serve(ending); }) {}

JointCalibrationJob::~JointCalibrationJob() {
  cancel();
  thread_.request_stop();
  thread_.join();
}

JointCalibrationJob::Job JointCalibrationJob::job() const {
  const std::lock_guard lock(mutex_);
  return newest_ ? newest_->job : Job{};
}

bool JointCalibrationJob::start(Order order) {
  auto running = std::make_shared<Running>();
  running->job.state = CalibrationState::kCollecting;
  running->job.order = std::make_shared<const Order>(std::move(order));
  {
    const std::lock_guard lock(mutex_);
    if (newest_ && is_running(newest_->job.state)) return false;
    newest_ = waiting_ = std::move(running);
  }
  ordered_.notify_one();
  return true;
}

bool JointCalibrationJob::cancel() {
  const std::lock_guard lock(mutex_);
  if (!newest_ || !is_running(newest_->job.state)) return false;
  // At once, though the thread may need a moment to see it: whatever comes of it then is not wanted.
  newest_->job.state = CalibrationState::kCancelled;
  newest_->stop.request_stop();
  return true;
}

bool JointCalibrationJob::forget(const JointReport* report) {
  const std::lock_guard lock(mutex_);
  if (!newest_ || is_running(newest_->job.state) || newest_->job.report.get() != report) return false;
  newest_.reset();
  return true;
}

void JointCalibrationJob::serve(const std::stop_token& ending) {
  become_background_thread("joint calib");
  for (;;) {
    RunningPtr running;
    {
      std::unique_lock lock(mutex_);
      if (!ordered_.wait(lock, ending, [&] { return waiting_ != nullptr; })) return;
      if (ending.stop_requested()) return;
      running = std::exchange(waiting_, nullptr);
    }
    work_on(running);
  }
}

template <class Change>
void JointCalibrationJob::change(const RunningPtr& running, Change change_job) {
  const std::lock_guard lock(mutex_);
  if (running->job.state != CalibrationState::kCancelled) change_job(running->job);
}

void JointCalibrationJob::work_on(const RunningPtr& running) {
  try {
    const std::optional<JointTask> task = collect(running);
    if (!task) return;
    change(running, [](Job& job) { job.state = CalibrationState::kSolving; });
    auto report = std::make_shared<const JointReport>(calibrate_jointly(*task, running->stop.get_token()));
    if (running->stop.stop_requested()) return;
    change(running, [&](Job& job) {
      job.state = CalibrationState::kDone;
      job.report = std::move(report);
    });
  } catch (const std::exception& error) {
    change(running, [&](Job& job) {
      job.state = CalibrationState::kFailed;
      job.problem = error.what();
    });
    log::warning("cameras not calibrated together: {}", error.what());
  }
}

std::optional<JointTask> JointCalibrationJob::collect(const RunningPtr& running) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLook{5};  // shorter than a camera's pause: no other's frame is missed
  const Order& order = *running->job.order;
  struct Watched {
    std::uint64_t version = 0;
    Clock::time_point heard;
  };
  JointTask task;
  task.field = order.field;
  std::vector<Watched> watched;
  for (const Camera& camera : order.cameras) {
    task.cameras.push_back({camera.id, {}, camera.calibration});
    // Only what comes from now on: the newest frame of a camera that is lost may be old.
    const auto newest = wait_frame_(camera.id, 0, std::chrono::milliseconds(0));
    watched.push_back({newest ? newest->version : 0, Clock::now()});
  }
  TieCollector collector(order.cameras.size());
  const auto frames = [&] {
    int least = order.request.frames;
    for (const CalibratedView& camera : task.cameras) least = std::min(least, camera.picture.frames());
    return least;
  };
  const auto until = Clock::now() + std::chrono::duration<double>(order.request.seconds);
  while (Clock::now() < until || frames() < order.request.frames) {
    for (std::size_t i = 0; i < watched.size(); ++i) {
      if (running->stop.stop_requested()) return std::nullopt;
      CalibratedView& camera = task.cameras[i];
      try {
        const auto frame = wait_frame_(camera.id, watched[i].version, kLook);
        if (!frame) {
          if (Clock::now() - watched[i].heard >= silence_) throw_no_picture(silence_);
          continue;
        }
        watched[i] = {frame->version, Clock::now()};
        collector.add(i, frame->t_capture_s, frame->robots);
        if (camera.picture.frames() < order.request.frames) add_frame(camera.picture, frame->image);
      } catch (const CaptureError& error) {
        throw CaptureError(fmt::format("camera {}: {}", camera.id, error.what()));
      }
    }
    change(running, [&](Job& job) {
      job.frames = frames();
      job.ties = static_cast<int>(collector.count());
    });
  }
  task.ties = collector.ties();
  return task;
}

}  // namespace sslv
