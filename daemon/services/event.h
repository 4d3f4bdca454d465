// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// Something that was done or that happened, for the history: no problem, but what explains one.
struct Event {
  std::string id;  // its kind: "settings_changed"
  std::string title;
  std::string who{};  // the client's address; empty: nobody did it
  std::optional<int> camera{};
};

/// Events until they are taken. May be used from any thread.
class EventQueue {
 public:
  static constexpr std::size_t kMax = 100;

  /// The newest are left out when nobody takes them.
  void add(Event event) {
    const std::lock_guard lock(mutex_);
    if (events_.size() < kMax) events_.push_back(std::move(event));
  }
  std::vector<Event> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(events_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<Event> events_;
};

}  // namespace sslv
