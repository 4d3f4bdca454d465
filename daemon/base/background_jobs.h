// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/background.h"

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

namespace sslv {

enum class JobState : std::uint8_t { kIdle, kCollecting, kSolving, kDone, kFailed, kCancelled };
const char* name_of(JobState state);
inline bool is_running(JobState state) {
  return state == JobState::kCollecting || state == JobState::kSolving;
}

/// Callbacks with which a job reports its progress.
struct JobProgress {
  std::function<void(int frames, int ties)> collected;
  std::function<void()> solving;
};

/// Runs jobs one at a time in a low-priority thread; accepts at most one unfinished job per key (for example
/// a camera's id). Keeps the state of each key's newest job. Thread-safe.
template <class Order, class Report>
class BackgroundJobs {
 public:
  struct Job {
    JobState state = JobState::kIdle;
    std::shared_ptr<const Order> order;    // null when idle
    int frames = 0;                        // collected so far, per camera
    int ties = 0;                          // tie points: positions at which two cameras saw the same robot
    std::shared_ptr<const Report> report;  // null until done
    std::string problem;                   // why the job failed; otherwise empty
  };

  /// Exceptions become the job's `problem`. The result of a stopped job is ignored.
  using Work = std::function<Report(int key, const Order& order, const JobProgress& progress,
                                    const std::stop_token& stop)>;

  using LogFailure = std::function<void(int key, const std::string& problem)>;

  /// `thread_name`: at most 15 characters. `become` sets the thread's priority (base/background.h).
  BackgroundJobs(const char* thread_name, Work work, LogFailure log_failure,
                 void (*become)(const char* name) = become_background_thread)
      : work_(std::move(work)),
        log_failure_(std::move(log_failure)),
        thread_([this, thread_name, become](const std::stop_token& ending) {
          become(thread_name);
          serve(ending);
        }) {}

  /// Stops the running job and waits for the thread.
  ~BackgroundJobs() { ask_to_stop(); }

  /// Requests the stop without waiting for it.
  void ask_to_stop() {
    thread_.request_stop();
    const std::lock_guard lock(mutex_);
    for (const auto& [key, running] : newest_) running->stop.request_stop();
  }

  Job job(int key) const {
    const std::lock_guard lock(mutex_);
    const auto found = newest_.find(key);
    return found == newest_.end() ? Job{} : found->second->job;
  }

  /// False if a job with this key is running already.
  bool start(int key, Order order) {
    auto running = std::make_shared<Running>();
    running->key = key;
    running->job.state = JobState::kCollecting;
    running->job.order = std::make_shared<const Order>(std::move(order));
    {
      const std::lock_guard lock(mutex_);
      RunningPtr& newest = newest_[key];
      if (newest && is_running(newest->job.state)) return false;
      newest = running;
      orders_.push_back(std::move(running));
    }
    ordered_.notify_one();
    return true;
  }

  /// False if no job with this key is running.
  bool cancel(int key) {
    const std::lock_guard lock(mutex_);
    const auto found = newest_.find(key);
    if (found == newest_.end() || !is_running(found->second->job.state)) return false;
    // Set the state now; the thread may notice the stop later, and its result is ignored.
    found->second->job.state = JobState::kCancelled;
    found->second->stop.request_stop();
    return true;
  }

  /// Removes a finished job. False if the key's job is running or has another report.
  bool forget(int key, const Report* report) {
    const std::lock_guard lock(mutex_);
    const auto found = newest_.find(key);
    if (found == newest_.end() || is_running(found->second->job.state) ||
        found->second->job.report.get() != report)
      return false;
    newest_.erase(found);
    return true;
  }

  /// Marks as failed the running jobs, and the jobs with a report, that `is_concerned` selects because their
  /// cameras have changed.
  void invalidate_if(const std::function<bool(int key, const Order& order)>& is_concerned) {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, running] : newest_) {
      Job& job = running->job;
      if ((!is_running(job.state) && !job.report) || !is_concerned(key, *job.order)) continue;
      running->stop.request_stop();
      job.state = JobState::kFailed;
      job.report = nullptr;
      job.problem = "the camera or its source has changed since; start again";
    }
  }

 private:
  struct Running {
    int key = 0;
    Job job;
    std::stop_source stop;
  };
  using RunningPtr = std::shared_ptr<Running>;

  void serve(const std::stop_token& ending) {
    for (;;) {
      RunningPtr running;
      {
        std::unique_lock lock(mutex_);
        if (!ordered_.wait(lock, ending, [&] { return !orders_.empty(); })) return;
        if (ending.stop_requested()) return;
        running = std::move(orders_.front());
        orders_.pop_front();
      }
      work_on(*running);
    }
  }

  void work_on(Running& running) {
    // Only the thread that requests a stop changes the state of a stopped job.
    const auto change = [&](const auto& change_job) {
      const std::lock_guard lock(mutex_);
      if (!running.stop.stop_requested()) change_job(running.job);
    };
    const JobProgress progress{[&](int frames, int ties) {
                                 change([&](Job& job) {
                                   job.frames = frames;
                                   job.ties = ties;
                                 });
                               },
                               [&] { change([](Job& job) { job.state = JobState::kSolving; }); }};
    try {
      auto report = std::make_shared<const Report>(
          work_(running.key, *running.job.order, progress, running.stop.get_token()));
      change([&](Job& job) {
        job.state = JobState::kDone;
        job.report = std::move(report);
      });
    } catch (const std::exception& error) {
      change([&](Job& job) {
        job.state = JobState::kFailed;
        job.problem = error.what();
      });
      log_failure_(running.key, error.what());
    }
  }

  const Work work_;
  const LogFailure log_failure_;
  mutable std::mutex mutex_;  // guards the following members and all jobs
  std::condition_variable_any ordered_;
  std::deque<RunningPtr> orders_;
  std::map<int, RunningPtr> newest_;  // by key
  std::jthread thread_;               // last: it uses all other members
};

}  // namespace sslv
