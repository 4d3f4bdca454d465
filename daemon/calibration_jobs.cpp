// SPDX-License-Identifier: Apache-2.0
#include "calibration_jobs.h"

#include "base/background.h"
#include "base/error.h"
#include "base/log.h"
#include "capture/source.h"

#include <exception>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

/// Points outside the picture are a mistake that the engine would search in vain for.
void check_points(const CalibrationRequest& request, const MeanPicture& picture) {
  for (std::size_t i = 0; i < request.points.size(); ++i) {
    const CalibrationPoint& point = request.points[i];
    const auto check = [&](const char* key, double value, int size) {
      if (value >= size) {
        throw SettingsError(
            fmt::format("/points/{}/{}: {:g} is not allowed; expected 0 .. {} px, as the picture is", i, key,
                        value, size - 1));
      }
    };
    check("x", point.x.value(), picture.width());
    check("y", point.y.value(), picture.height());
  }
}

}  // namespace

const char* name_of(CalibrationState state) {
  switch (state) {
    case CalibrationState::kIdle: return "idle";
    case CalibrationState::kCollecting: return "collecting";
    case CalibrationState::kSolving: return "solving";
    case CalibrationState::kDone: return "done";
    case CalibrationState::kFailed: return "failed";
    case CalibrationState::kCancelled: break;
  }
  return "cancelled";
}

bool is_running(CalibrationState state) {
  return state == CalibrationState::kCollecting || state == CalibrationState::kSolving;
}

void add_frame(MeanPicture& mean, const ImageView& frame) {
  if (mean.add(frame)) return;
  throw CaptureError(mean.frames() == 0
                         ? fmt::format("the camera's pictures have no colours ({})", name_of(frame.format))
                         : "the camera's pictures have changed meanwhile; start again");
}

void throw_no_picture(std::chrono::milliseconds silence) {
  throw CaptureError(fmt::format("no picture came for {:g} s; is the camera running?",
                                 std::chrono::duration<double>(silence).count()));
}

CalibrationJobs::CalibrationJobs(WaitFrame wait_frame, std::chrono::milliseconds silence)
    : wait_frame_(std::move(wait_frame)),
      silence_(silence),
      thread_([this](const std::stop_token& ending) { serve(ending); }) {}

CalibrationJobs::~CalibrationJobs() {
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, running] : newest_) running->stop.request_stop();
  }
  thread_.request_stop();
  thread_.join();
}

CalibrationJobs::Job CalibrationJobs::job(int camera_id) const {
  const std::lock_guard lock(mutex_);
  const auto found = newest_.find(camera_id);
  return found == newest_.end() ? Job{} : found->second->job;
}

bool CalibrationJobs::start(int camera_id, Order order) {
  auto running = std::make_shared<Running>();
  running->camera_id = camera_id;
  running->job.state = CalibrationState::kCollecting;
  running->job.order = std::make_shared<const Order>(std::move(order));
  {
    const std::lock_guard lock(mutex_);
    RunningPtr& newest = newest_[camera_id];
    if (newest && is_running(newest->job.state)) return false;
    newest = running;
    orders_.push_back(std::move(running));
  }
  ordered_.notify_one();
  return true;
}

bool CalibrationJobs::cancel(int camera_id) {
  const std::lock_guard lock(mutex_);
  const auto found = newest_.find(camera_id);
  if (found == newest_.end() || !is_running(found->second->job.state)) return false;
  // At once, though the thread may need a moment to see it: whatever comes of it then is not wanted.
  found->second->job.state = CalibrationState::kCancelled;
  found->second->stop.request_stop();
  return true;
}

bool CalibrationJobs::forget(int camera_id, const CalibrationReport* report) {
  const std::lock_guard lock(mutex_);
  const auto found = newest_.find(camera_id);
  if (found == newest_.end() || is_running(found->second->job.state) ||
      found->second->job.report.get() != report)
    return false;
  newest_.erase(found);
  return true;
}

void CalibrationJobs::invalidate(int camera_id) {
  const std::lock_guard lock(mutex_);
  const auto found = newest_.find(camera_id);
  if (found == newest_.end()) return;
  found->second->stop.request_stop();
  Job& job = found->second->job;
  job.state = CalibrationState::kFailed;
  job.report = nullptr;
  job.problem = "the camera or its source was changed since; start again";
}

void CalibrationJobs::serve(const std::stop_token& ending) {
  become_background_thread("calibration");
  for (;;) {
    RunningPtr running;
    {
      std::unique_lock lock(mutex_);
      if (!ordered_.wait(lock, ending, [&] { return !orders_.empty(); })) return;
      if (ending.stop_requested()) return;
      running = std::move(orders_.front());
      orders_.pop_front();
    }
    work_on(running);
  }
}

template <class Change>
void CalibrationJobs::change(const RunningPtr& running, Change change_job) {
  const std::lock_guard lock(mutex_);
  if (!running->stop.stop_requested()) change_job(running->job);
}

void CalibrationJobs::work_on(const RunningPtr& running) {
  const auto fail = [&](const std::string& problem) {
    change(running, [&](Job& job) {
      job.state = CalibrationState::kFailed;
      job.problem = problem;
    });
    log::warning("camera {}: not calibrated: {}", running->camera_id, problem);
  };
  try {
    const Order& order = *running->job.order;
    const std::optional<MeanPicture> picture = collect(running);
    if (!picture) return;
    check_points(order.request, *picture);
    change(running, [](Job& job) { job.state = CalibrationState::kSolving; });
    auto report = std::make_shared<const CalibrationReport>(calibrate(
        *picture, make_task(order.request, order.field, order.previous), running->stop.get_token()));
    if (running->stop.stop_requested()) return;
    change(running, [&](Job& job) {
      job.state = CalibrationState::kDone;
      job.report = std::move(report);
    });
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

std::optional<MeanPicture> CalibrationJobs::collect(const RunningPtr& running) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLook{100};  // how soon a cancellation is seen
  const int camera_id = running->camera_id;
  MeanPicture mean;
  // Only what comes from now on: the newest frame of a camera that is lost may be old.
  std::uint64_t version = 0;
  if (const auto newest = wait_frame_(camera_id, 0, std::chrono::milliseconds(0))) version = newest->version;
  auto heard = Clock::now();
  while (mean.frames() < running->job.order->request.frames) {
    if (running->stop.stop_requested()) return std::nullopt;
    const auto frame = wait_frame_(camera_id, version, kLook);
    if (!frame) {
      if (Clock::now() - heard < silence_) continue;
      throw_no_picture(silence_);
    }
    heard = Clock::now();
    version = frame->version;
    add_frame(mean, frame->image);
    change(running, [&](Job& job) { job.frames = mean.frames(); });
  }
  return mean;
}

}  // namespace sslv
