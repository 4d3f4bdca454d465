// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/open_file.h"

#include <cstdint>
#include <string>

#include <sys/types.h>

namespace sslv {

/// A process that runs code of a stage library, in its own process group. The destructor kills the whole
/// group.
class ChildProcess {
 public:
  ChildProcess() = default;
  /// Owns a process that was just started. If the process cannot be watched, ends it and throws
  /// std::system_error.
  explicit ChildProcess(pid_t pid);
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Becomes readable when the process ends (pidfd_open(2)); -1 without a process.
  int fd() const { return end_.fd(); }
  bool has_ended(int within_ms = 0) const;

  /// Extension of the process's time limit, in ns: the time for which the process was runnable but had no
  /// processor, at most `most_ns`. 0 once the process has ended.
  std::int64_t grace_ns(std::int64_t most_ns) const;

  /// Kills the process and its group without waiting.
  void kill() noexcept;
  /// Kills the remaining group and waits for the process. Returns its status (waitpid(2)), 0 without a
  /// process.
  int end() noexcept;

 private:
  pid_t pid_ = -1;  // valid until the process has been waited for
  OpenFile end_;
};

/// "ended by signal 11", "ended with exit code 1".
std::string end_text(int status);

}  // namespace sslv
