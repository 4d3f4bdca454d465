// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/kept_files.h"

#include <chrono>
#include <string>
#include <vector>

#include <sys/types.h>

namespace sslv::test {

/// A program started by a test: collects its output and kills it when the test ends.
class ChildProcess {
 public:
  /// The first word is the program. `environment`: entries "NAME=value" in addition to this process' own.
  /// `kept`: files that the service manager has kept for it.
  explicit ChildProcess(const std::vector<std::string>& words,
                        const std::vector<std::string>& environment = {},
                        const std::vector<KeptFile>& kept = {});
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Reads its output (standard output and error together) until a line contains `text`, and returns that
  /// line. Throws std::runtime_error with all output if the program ends or kPatience passes first.
  std::string wait_for_line(const std::string& text);

  void send_signal(int signal) const;

  /// Waits for its end; returns the exit code, or 128 + signal. Throws like wait_for_line().
  int wait_for_exit();

  /// Valid while it runs.
  pid_t pid() const { return pid_; }

  /// Its output read so far.
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
