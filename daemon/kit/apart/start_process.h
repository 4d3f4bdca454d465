// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

namespace sslv::apart {

/// A file that is closed with this.
class OwnedFile {
 public:
  explicit OwnedFile(int file = -1) : file_(file) {}
  OwnedFile(OwnedFile&& other) noexcept : file_(other.release()) {}
  OwnedFile& operator=(OwnedFile&& other) noexcept {
    if (this != &other) reset(other.release());
    return *this;
  }
  OwnedFile(const OwnedFile&) = delete;
  OwnedFile& operator=(const OwnedFile&) = delete;
  ~OwnedFile() { reset(); }

  int get() const { return file_; }
  explicit operator bool() const { return file_ >= 0; }
  int release() {
    const int file = file_;
    file_ = -1;
    return file;
  }
  void reset(int file = -1);

 private:
  int file_;
};

struct FilePair {
  OwnedFile ours, theirs;
};
/// Two ends of a local socket (socket(7)) of this type. Throws std::system_error.
FilePair local_sockets(int type);
/// The end that is read is `ours`, and reading never waits. Throws std::system_error.
FilePair output_pipe();

/// The first argument of a process that runs stages (stage_process.h).
inline constexpr std::string_view kStageProcessFlag = "--stage-process";
/// Where it finds what it was given.
inline constexpr int kControlFile = 3, kToStageFile = 4, kFromStageFile = 5;

struct StartedProcess {
  pid_t pid = -1;
  OwnedFile pidfd;  // can be read once it has ended (pidfd_open(2))
};
/// Starts this program again: with `files` as 3, 4, ..., `output` as what it prints to, no other file, no
/// blocked signal, and in a process group of its own. It ends when the calling thread does. Throws
/// std::system_error.
StartedProcess start_stage_process(const std::vector<std::string>& arguments, const std::vector<int>& files,
                                   int output);

/// Ends the process and all that it started.
void kill_stage_process(const StartedProcess& process) noexcept;
/// How a process ended, after waiting for that: "ended by signal 11", "ended with exit code 1".
std::string wait_for_end(const StartedProcess& process);

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
