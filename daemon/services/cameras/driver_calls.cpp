// SPDX-License-Identifier: Apache-2.0
#include "services/cameras/driver_calls.h"

#include "base/left_behind.h"
#include "capture/source.h"

#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace sslv {

struct DriverCalls::Shared {
  std::chrono::milliseconds patience, patience_with_others;
  std::mutex mutex;  // guards what follows, and the results of calls
  std::condition_variable changed;
  bool busy = false, ends = false;
};

namespace {

constexpr const char* kEnds = "it is being closed";

struct Call {
  std::function<Json()> run;
  Json result;
  std::exception_ptr error;
  bool done = false;
};

}  // namespace

DriverCalls::DriverCalls(std::chrono::milliseconds patience, std::chrono::milliseconds patience_with_others)
    : shared_(std::make_shared<Shared>()) {
  shared_->patience = patience;
  shared_->patience_with_others = patience_with_others;
}

Json DriverCalls::run(std::function<Json()> function) const {
  const auto call = std::make_shared<Call>();
  call->run = std::move(function);
  std::unique_lock lock(shared_->mutex);
  if (!shared_->changed.wait_for(lock, shared_->patience_with_others,
                                 [&] { return !shared_->busy || shared_->ends; }))
    throw CaptureError("the camera has not answered an earlier request yet; try again later");
  if (shared_->ends) throw CaptureError(kEnds);
  std::thread([shared = shared_, call, left = std::make_unique<LeftBehind>()] {
    Json result;
    std::exception_ptr error;
    try {
      result = call->run();
    } catch (...) {
      error = std::current_exception();
    }
    call->run = nullptr;  // what it owns is destroyed here, not by the thread that waits
    const std::lock_guard done(shared->mutex);
    call->result = std::move(result);
    call->error = std::move(error);
    call->done = true;
    shared->busy = false;
    shared->changed.notify_all();
  }).detach();
  shared_->busy = true;
  if (!shared_->changed.wait_for(lock, shared_->patience, [&] { return call->done || shared_->ends; })) {
    throw CaptureError(fmt::format("the camera has not answered for {:g} s",
                                   std::chrono::duration<double>(shared_->patience).count()));
  }
  if (!call->done) throw CaptureError(kEnds);
  // Taken out: the other thread may be the last to let go of `call`.
  if (const std::exception_ptr error = std::exchange(call->error, nullptr)) std::rethrow_exception(error);
  return std::move(call->result);
}

void DriverCalls::ask_to_stop() const {
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->ends = true;
  }
  shared_->changed.notify_all();
}

}  // namespace sslv
