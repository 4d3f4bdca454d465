// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/open_file.h"
#include "kit/child_process.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sslv::sandbox {

struct FilePair {
  OpenFile ours, theirs;
};
/// Two ends of a local socket (socket(7)) of this type. Throws std::system_error.
FilePair local_sockets(int type);
/// A pipe; `ours` is the read end and non-blocking. Throws std::system_error.
FilePair output_pipe();

/// The first argument of a process that runs stages (stage_process.h).
inline constexpr std::string_view kStageProcessFlag = "--stage-process";
/// File descriptors that such a process inherits.
inline constexpr int kControlFile = 3, kToStageFile = 4, kFromStageFile = 5;

/// Starts this program again, with `files` as file descriptors 3, 4, ..., `output` as stdout and stderr, no
/// other files and no blocked signals. The process also ends when the calling thread ends. Throws
/// std::system_error.
ChildProcess start_stage_process(const std::vector<std::string>& arguments, const std::vector<int>& files,
                                 int output);

/// Logs the output of a process, line by line as plain text, at most kLinesASecond.
class OutputLines {
 public:
  static constexpr int kLinesASecond = 20;
  static constexpr std::size_t kLongestLine = 500;

  explicit OutputLines(std::string name) : name_(std::move(name)) {}
  /// Logs the available output without waiting. False at the end of the output.
  bool read(int file, std::int64_t now_ns);
  /// Logs the last line, which may lack its newline.
  void end(std::int64_t now_ns);

 private:
  void add(std::string_view text, std::int64_t now_ns);
  void line(std::string_view text, std::int64_t now_ns);

  std::string name_, rest_;
  std::int64_t second_ns_ = 0;
  int lines_ = 0, left_out_ = 0;
};

}  // namespace sslv::sandbox
