// SPDX-License-Identifier: Apache-2.0
#include "services/status/heartbeat.h"

#include "base/background.h"
#include "base/log.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stop_token>
#include <utility>

namespace sslv {

Heartbeat::Heartbeat(std::vector<Service*> services, std::function<std::string()> make_summary)
    : services_(std::move(services)),
      make_summary_(std::move(make_summary)),
      summary_(make_summary_()),
      thread_([this](const std::stop_token& stop) {
        become_background_thread("heartbeat");
        std::mutex idle;
        std::condition_variable_any alarm;
        std::unique_lock lock(idle);
        auto next = std::chrono::steady_clock::now();
        for (;;) {
          // At even intervals; missed seconds are skipped.
          next = std::max(next + std::chrono::seconds(1), std::chrono::steady_clock::now());
          alarm.wait_until(lock, stop, next, [&] { return stop.stop_requested(); });
          if (stop.stop_requested()) return;
          beat(stop);
        }
      }) {}

void Heartbeat::beat(const std::stop_token& stop) noexcept {
  const auto call = [](const auto& act) {
    try {
      act();
    } catch (const std::exception& error) {  // the other calls are still made
      log::error("a task that runs once a second failed: {}", error.what());
    }
  };
  for (Service* service : services_) {
    if (stop.stop_requested()) return;
    call([&] { service->each_second(); });
  }
  call([this] { summary_.store(make_summary_()); });
}

}  // namespace sslv
