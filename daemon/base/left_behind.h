// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

namespace sslv {

/// Counts detached threads. Create an object before detaching a thread, and let the thread own the object
/// until the thread ends. While any() is true, the program must not end by exit(), which destroys objects
/// that the thread may use.
class LeftBehind {
 public:
  LeftBehind() { ++count(); }
  ~LeftBehind() { --count(); }
  LeftBehind(const LeftBehind&) = delete;
  LeftBehind& operator=(const LeftBehind&) = delete;

  static bool any() { return count() > 0; }

 private:
  static std::atomic<int>& count() {
    static std::atomic<int> count{0};
    return count;
  }
};

}  // namespace sslv
