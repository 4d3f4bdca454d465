// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/open_file.h"

#include <cstdint>
#include <string>

#include <sys/types.h>

namespace sslv {

/// A process that runs code of a stage library, in a process group of its own. It ends with this object at
/// the latest, and with it all of its group.
class ChildProcess {
 public:
  ChildProcess() = default;
  /// One that was just started. Throws std::system_error when it cannot be watched; then it has ended.
  explicit ChildProcess(pid_t pid);
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Can be read once it has ended (pidfd_open(2)); -1: there is none.
  int fd() const { return end_.fd(); }
  bool has_ended(int within_ms = 0) const;

  /// How much later than its limit it may be done, `most_ns` at most: it wanted a processor for so long and
  /// got none. 0 once it has ended.
  std::int64_t grace_ns(std::int64_t most_ns) const;

  /// It and all of its group; waits for nothing.
  void kill() noexcept;
  /// Kills what is left of the group and waits for the process: its status (waitpid(2)), 0 if there is none.
  int end() noexcept;

 private:
  pid_t pid_ = -1;  // its own until it was waited for
  OpenFile end_;
};

/// "ended by signal 11", "ended with exit code 1".
std::string end_text(int status);

}  // namespace sslv
