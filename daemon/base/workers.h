// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

namespace sslv {

/// Threads that share the parts of one job with the calling thread. They sleep between jobs. Without threads,
/// the caller does the whole job.
class Workers {
 public:
  /// The threads inherit the caller's priority and processors. If the system does not provide all threads,
  /// there are fewer, see threads().
  explicit Workers(int threads) noexcept
      : Workers(threads, [](auto serve) { return std::jthread(std::move(serve)); }) {}
  /// `make` starts a thread that runs the given function, or throws.
  template <class Make>
  Workers(int threads, const Make& make) noexcept {
    try {
      threads_.reserve(static_cast<std::size_t>(threads));
      for (int i = 0; i < threads; ++i) threads_.push_back(make([this] { serve(); }));
    } catch (const std::exception&) {  // continue with the threads created so far, or with the caller alone
    }
  }
  ~Workers() {
    ending_.store(true, std::memory_order_relaxed);
    begin_job(nullptr, nullptr, 0);
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int threads() const { return static_cast<int>(threads_.size()); }

  /// Calls part(i) once for every i in [0, parts), from several threads in parallel, and returns when all
  /// calls have returned. One job at a time. Allocates nothing; `part` must not throw.
  template <class Part>
  void run(int parts, const Part& part) noexcept {
    if (threads_.empty()) {
      for (int i = 0; i < parts; ++i) part(i);
      return;
    }
    begin_job([](const void* context, int i) { (*static_cast<const Part*>(context))(i); }, &part, parts);
    take_parts();
    // All parts are taken: wait for the threads that are still working.
    for (int busy = busy_.load(std::memory_order_acquire); busy != 0;
         busy = busy_.load(std::memory_order_acquire))
      busy_.wait(busy, std::memory_order_acquire);
  }

 private:
  using Call = void (*)(const void* context, int part);

  void begin_job(Call call, const void* context, int parts) {
    call_ = call;
    context_ = context;
    parts_ = parts;
    next_.store(0, std::memory_order_relaxed);
    busy_.store(static_cast<int>(threads_.size()), std::memory_order_relaxed);
    job_.fetch_add(1, std::memory_order_release);
    job_.notify_all();
  }

  void take_parts() {
    for (int i = next_.fetch_add(1, std::memory_order_relaxed); i < parts_;
         i = next_.fetch_add(1, std::memory_order_relaxed)) {
      call_(context_, i);
    }
  }

  void serve() {
    for (std::uint32_t done = 0;; ++done) {
      job_.wait(done, std::memory_order_acquire);
      if (ending_.load(std::memory_order_relaxed)) return;
      take_parts();
      if (busy_.fetch_sub(1, std::memory_order_release) == 1) busy_.notify_one();
    }
  }

  Call call_ = nullptr;
  const void* context_ = nullptr;
  int parts_ = 0;
  std::atomic<int> next_{0};           // next part to take
  std::atomic<int> busy_{0};           // threads that have not finished the job
  std::atomic<std::uint32_t> job_{0};  // number of the newest job
  std::atomic<bool> ending_{false};
  std::vector<std::jthread> threads_;
};

}  // namespace sslv
