// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/open_file.h"
#include "kit/child_process.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sslv::apart {

struct FilePair {
  OpenFile ours, theirs;
};
/// Two ends of a local socket (socket(7)) of this type. Throws std::system_error.
FilePair local_sockets(int type);
/// The end that is read is `ours`, and reading never waits. Throws std::system_error.
FilePair output_pipe();

/// The first argument of a process that runs stages (stage_process.h).
inline constexpr std::string_view kStageProcessFlag = "--stage-process";
/// Where it finds what it was given.
inline constexpr int kControlFile = 3, kToStageFile = 4, kFromStageFile = 5;

/// Starts this program again: with `files` as 3, 4, ..., `output` as what it prints to, no other file and no
/// blocked signal. It ends when the calling thread does, too. Throws std::system_error.
ChildProcess start_stage_process(const std::vector<std::string>& arguments, const std::vector<int>& files,
                                 int output);

/// What a process prints, for the log, line by line: at most so many lines a second, each shown as plain
/// text.
class OutputLines {
 public:
  static constexpr int kLinesASecond = 20;
  static constexpr std::size_t kLongestLine = 500;

  explicit OutputLines(std::string name) : name_(std::move(name)) {}
  /// Logs what is there to read; never waits. False: there will be no more.
  bool read(int file, std::int64_t now_ns);
  /// The last line, which may lack its end.
  void end(std::int64_t now_ns);

 private:
  void add(std::string_view text, std::int64_t now_ns);
  void line(std::string_view text, std::int64_t now_ns);

  std::string name_, rest_;
  std::int64_t second_ns_ = 0;
  int lines_ = 0, left_out_ = 0;
};

}  // namespace sslv::apart
