// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/kept_files.h"

#include <chrono>
#include <string>
#include <vector>

#include <sys/types.h>

namespace sslv::test {

/// A program started by a test: its output is collected, and it is killed when the test ends.
class ChildProcess {
 public:
  /// The first word is the program. `environment` entries are "NAME=value", beside this process' own. `kept`:
  /// what the service manager kept for it.
  explicit ChildProcess(const std::vector<std::string>& words,
                        const std::vector<std::string>& environment = {},
                        const std::vector<KeptFile>& kept = {});
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Reads on (standard output and error together) until a line holds `text`, and returns that line. Throws
  /// std::runtime_error with all of the output when the program ends or kPatience does first.
  std::string wait_for_line(const std::string& text);

  void send_signal(int signal) const;

  /// Waits for the end; the exit code, or 128 + signal. Throws like wait_for_line.
  int wait_for_exit();

  /// While it runs.
  pid_t pid() const { return pid_; }

  /// Everything it has printed so far.
  const std::string& output() const { return output_; }

 private:
  bool read_some(std::chrono::steady_clock::time_point deadline);

  std::string name_;
  pid_t pid_ = -1;
  int pipe_ = -1;
  std::string output_;
  std::size_t searched_ = 0;
};

struct Finished {
  int exit_code;
  std::string output;
};
/// Runs a program to its end.
Finished run_to_end(const std::vector<std::string>& words, const std::vector<std::string>& environment = {});

}  // namespace sslv::test
