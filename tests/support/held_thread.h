// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "support/patience.h"

#include <atomic>
#include <cerrno>
#include <csignal>
#include <functional>
#include <memory>
#include <semaphore>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <pthread.h>
#include <semaphore.h>

namespace sslv {

#if defined(__SANITIZE_THREAD__)
inline constexpr bool kHasLateSignals = true;
#elif defined(__has_feature)
inline constexpr bool kHasLateSignals = __has_feature(thread_sanitizer);
#else
inline constexpr bool kHasLateSignals = false;
#endif

/// A thread that repeats an action and can be paused anywhere in it, as the scheduler pauses an idle-class
/// thread while others need its processor.
class HeldThread {
 public:
  explicit HeldThread(std::function<void()> act) {
    struct sigaction action {};
    action.sa_handler = &HeldThread::wait_in_handler;
    action.sa_flags = SA_RESTART;
    sigaction(kSignal, &action, nullptr);
    sem_init(&is_held_, 0, 0);
    sem_init(&may_go_on_, 0, 0);
    std::binary_semaphore started(0);
    thread_ = std::thread([this, act = std::move(act), &started] {
      self_ = this;
      started.release();
      while (!ending_) act();
    });
    started.acquire();
  }
  ~HeldThread() {
    ending_ = true;
    thread_.join();
    sem_destroy(&is_held_);
    sem_destroy(&may_go_on_);
  }
  HeldThread(const HeldThread&) = delete;
  HeldThread& operator=(const HeldThread&) = delete;

  /// Returns when it is paused.
  void hold() {
    pthread_kill(thread_.native_handle(), kSignal);
    wait(is_held_);
  }
  void go_on() { sem_post(&may_go_on_); }

 private:
  static inline const int kSignal = SIGRTMIN + 5;

  static void wait(sem_t& semaphore) {
    while (sem_wait(&semaphore) != 0) {
    }
  }
  static void wait_in_handler(int) {
    const int before = errno;
    sem_post(&self_->is_held_);
    wait(self_->may_go_on_);
    errno = before;
  }

  static inline thread_local HeldThread* self_ = nullptr;
  sem_t is_held_, may_go_on_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

/// Checks that a camera's `work` completes although a thread that repeats `act` is paused anywhere in it;
/// many times, at different places. If they share a lock, `work` sooner or later waits forever. `work` must
/// not allocate, as the allocator has its own locks.
inline void expect_never_waits(const std::function<void()>& act, const std::function<void()>& work,
                               int times = 1000) {
  if (kHasLateSignals) GTEST_SKIP() << "ThreadSanitizer delivers signals only between the calls it watches";
  std::binary_semaphore begin(0), done(0);
  std::atomic<bool> ending{false};
  std::thread camera([&] {
    for (begin.acquire(); !ending; begin.acquire()) {
      work();
      done.release();
    }
  });
  {
    HeldThread reader(act);
    bool is_done = true;
    for (int i = 0; i < times && is_done; ++i) {
      for (std::atomic<int> spin{0}; spin < i * 7919 % 5000;) ++spin;
      reader.hold();
      begin.release();
      is_done = done.try_acquire_for(test::kPatience);
      reader.go_on();
      EXPECT_TRUE(is_done) << "it waits for a thread that is held, at the latest the " << i + 1 << "th time";
      if (!is_done) done.acquire();
    }
  }
  ending = true;
  begin.release();
  camera.join();
}

}  // namespace sslv
