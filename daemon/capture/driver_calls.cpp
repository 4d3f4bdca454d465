// SPDX-License-Identifier: Apache-2.0
#include "capture/driver_calls.h"

#include "base/background.h"
#include "base/left_behind.h"
#include "capture/source.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr const char* kEnds = "it is being closed";
constexpr const char* kHasNotAnswered = "the camera has not answered an earlier request yet; try again later";

}  // namespace

struct DriverCalls::Call {
  std::function<void()> run;
  std::exception_ptr error{};
  bool has_begun = false, is_done = false;
};

struct DriverCalls::Shared : std::enable_shared_from_this<Shared> {
  std::chrono::milliseconds patience, patience_with_others;
  std::mutex mutex;  // guards the following members and the calls, except `run`
  std::condition_variable changed;
  std::deque<Posted> waiting;
  bool is_running = false, ends = false;  // whether the thread exists; whether ask_to_stop() was called

  /// Requires the lock.
  Posted add(std::function<void()> run) {
    if (ends) throw CaptureError(kEnds);
    auto call = std::make_shared<Call>(Call{std::move(run)});
    if (!is_running) {
      std::thread([shared = shared_from_this(), left = std::make_unique<LeftBehind>()] {
        become_background_thread("driver calls");
        shared->run_all();
      }).detach();
      is_running = true;
      call->has_begun = true;  // count the first call as begun, even if the thread starts late
    }
    waiting.push_back(call);
    return call;
  }

  void wait(std::unique_lock<std::mutex>& lock, Call& call) {
    if (!changed.wait_for(lock, patience, [&] { return call.is_done || ends; })) {
      throw CaptureError(fmt::format("the camera has not answered for {:g} s",
                                     std::chrono::duration<double>(patience).count()));
    }
    if (!call.is_done) throw CaptureError(kEnds);
    // Moved out of `call`, because the other thread may be the last to release `call`.
    if (const std::exception_ptr error = std::exchange(call.error, nullptr)) std::rethrow_exception(error);
  }

  void run_all() {
    std::unique_lock lock(mutex);
    while (!waiting.empty()) {
      const Posted call = std::move(waiting.front());
      waiting.pop_front();
      call->has_begun = true;
      changed.notify_all();
      lock.unlock();
      std::exception_ptr error;
      try {
        call->run();
      } catch (...) {
        error = std::current_exception();
      }
      call->run = nullptr;  // destroy its captures here, not on the waiting thread
      lock.lock();
      call->error = std::move(error);
      call->is_done = true;
      changed.notify_all();
    }
    is_running = false;
  }
};

DriverCalls::DriverCalls(std::chrono::milliseconds patience, std::chrono::milliseconds patience_with_others)
    : shared_(std::make_shared<Shared>()) {
  shared_->patience = patience;
  shared_->patience_with_others = patience_with_others;
}

void DriverCalls::run_in_turn(std::function<void()> function) const {
  std::unique_lock lock(shared_->mutex);
  const Posted call = shared_->add(std::move(function));
  if (!shared_->changed.wait_for(lock, shared_->patience_with_others,
                                 [&] { return call->has_begun || shared_->ends; })) {
    std::erase(shared_->waiting, call);
    throw CaptureError(kHasNotAnswered);
  }
  shared_->wait(lock, *call);
}

DriverCalls::Posted DriverCalls::post(std::function<void()> call) const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->add(std::move(call));
}

void DriverCalls::wait(const Posted& call) const {
  std::unique_lock lock(shared_->mutex);
  shared_->wait(lock, *call);
}

void DriverCalls::ask_to_stop() const {
  std::deque<Posted> dropped;
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->ends = true;
    dropped.swap(shared_->waiting);
  }
  shared_->changed.notify_all();
}

}  // namespace sslv
