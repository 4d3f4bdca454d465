// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace sslv {

/// A value that any thread can replace and one thread, the user, reads without ever blocking. The user takes
/// no lock and never frees a value: a later store() or load() frees a replaced value, on its own thread, once
/// the user has released it (the user holds a hazard pointer, see Michael 2004, IEEE TPDS 15(6)).
template <class T>
class Handover {
 public:
  explicit Handover(T first) { store(std::move(first)); }
  Handover(const Handover&) = delete;
  Handover& operator=(const Handover&) = delete;

  /// From any thread except the user's.
  void store(T value) {
    auto next = std::make_shared<const T>(std::move(value));
    Versions left;  // destroyed after the lock is released
    const std::lock_guard lock(mutex_);
    kept_.push_back(std::move(next));
    newest_.store(kept_.back().get());
    left = take_left();
  }

  /// The newest version; the caller may keep it for any time. From any thread except the user's.
  std::shared_ptr<const T> load() const {
    Versions left;
    const std::lock_guard lock(mutex_);
    left = take_left();
    return kept_.back();
  }

  /// Keeps the version in use that was newest when use() was called.
  class Use {
   public:
    ~Use() { in_use_.store(nullptr, std::memory_order_release); }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    const T& operator*() const { return *value_; }
    const T* operator->() const { return value_; }

   private:
    friend class Handover;
    Use(const T* value, std::atomic<const T*>& in_use) : value_(value), in_use_(in_use) {}
    const T* const value_;
    std::atomic<const T*>& in_use_;
  };

  /// Only for the user, one Use at a time.
  Use use() noexcept {
    const T* value = newest_.load();
    for (;;) {
      in_use_.store(value);
      // From now on no writer frees this version, unless it was replaced before the store.
      const T* const now = newest_.load();
      if (now == value) return Use(value, in_use_);
      value = now;
    }
  }

 private:
  using Versions = std::vector<std::shared_ptr<const T>>;

  /// The versions that are neither the newest nor in use. Requires the lock.
  Versions take_left() const {
    Versions left;
    const T* const in_use = in_use_.load();
    const auto is_wanted = [&](const auto& one) { return one == kept_.back() || one.get() == in_use; };
    const auto begin = std::stable_partition(kept_.begin(), kept_.end() - 1, is_wanted);
    left.assign(std::make_move_iterator(begin), std::make_move_iterator(kept_.end() - 1));
    kept_.erase(begin, kept_.end() - 1);
    return left;
  }

  mutable std::mutex mutex_;  // locked by store() and load(), never by the user
  mutable Versions kept_;     // guarded by mutex_; the last is the newest
  std::atomic<const T*> newest_{nullptr};
  std::atomic<const T*> in_use_{nullptr};
};

}  // namespace sslv
