// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

namespace sslv {

/// One lives in each thread that nobody waits for, from before the thread is let go of until its end. While
/// there is one, the program must not end by exit(): that destroys what the thread may be using.
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
