// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace sslv {

/// A mailbox for one value: the writer never waits, and a newer value replaces an unread one. Each reader
/// remembers the last version it read, so several may read the same value. T is copied under the lock, so it
/// should be a handle.
template <class T>
class Latest {
 public:
  struct Versioned {
    std::uint64_t version;
    T value;
  };

  void put(T value) {
    {
      const std::lock_guard lock(mutex_);
      if (closed_) return;
      std::swap(value_, value);
      ++version_;
    }
    changed_.notify_all();
  }  // the replaced value is released here, outside the lock

  /// The current value, if there is one.
  std::optional<Versioned> peek() const {
    const std::lock_guard lock(mutex_);
    if (version_ == 0 || closed_) return std::nullopt;
    return Versioned{version_, value_};
  }

  /// Waits for a version newer than `seen` (0: any). nullopt on timeout or after close().
  std::optional<Versioned> wait_newer(std::uint64_t seen, std::chrono::milliseconds timeout) const {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, timeout, [&] { return version_ > seen || closed_; });
    if (version_ <= seen || closed_) return std::nullopt;
    return Versioned{version_, value_};
  }

  /// Wakes all readers for good, releases the value, and ignores later ones.
  void close() {
    T old{};
    {
      const std::lock_guard lock(mutex_);
      std::swap(value_, old);
      closed_ = true;
    }
    changed_.notify_all();
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  T value_{};
  std::uint64_t version_ = 0;
  bool closed_ = false;
};

}  // namespace sslv
