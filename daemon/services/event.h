// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sslv {

/// An action or an occurrence for the history. It is not a problem itself, but may explain one.
struct Event {
  std::string id;  // its kind, for example "settings_changed"
  std::string title;
  std::string who{};  // address of the client that caused it; empty: no client
  std::optional<int> camera{};
};

/// Queue of events until take() fetches them. Thread-safe.
class EventQueue {
 public:
  static constexpr std::size_t kMax = 100;

  /// Drops the event if kMax events are already waiting.
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
