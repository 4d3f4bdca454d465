// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <utility>

namespace sslv {

/// A value written rarely by one thread and read often by other threads. A reader may hold an immutable
/// version for any time; a writer never waits for readers. The mutex guards one pointer copy.
template <class T>
class Snapshot {
 public:
  Snapshot() = default;
  explicit Snapshot(std::shared_ptr<const T> value) : value_(std::move(value)) {}
  explicit Snapshot(T value) : value_(std::make_shared<const T>(std::move(value))) {}

  /// The newest version; null only before the first store of a default-constructed Snapshot.
  std::shared_ptr<const T> load() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }

  void store(T value) { store(std::make_shared<const T>(std::move(value))); }
  void store(std::shared_ptr<const T> next) noexcept {
    const std::lock_guard lock(mutex_);
    value_.swap(next);  // the old version is released after the lock
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const T> value_;
};

}  // namespace sslv
