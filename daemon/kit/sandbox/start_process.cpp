// SPDX-License-Identifier: Apache-2.0
#include "kit/sandbox/start_process.h"

#include "base/log.h"
#include "base/plain_text.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <unistd.h>

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX leaves the declaration to the user

namespace sslv::sandbox {
namespace {

[[noreturn]] void fail_start(const char* what, int error) {
  throw std::system_error(error, std::system_category(), what);
}

/// A copy of a file descriptor, numbered above all descriptors of the stage's process, so that dup2
/// overwrites no descriptor that is still to be copied.
OpenFile copy_above(int file) {
  constexpr int kAbove = 32;
  OpenFile copy(::fcntl(file, F_DUPFD_CLOEXEC, kAbove));
  if (!copy.is_open()) fail_start("F_DUPFD_CLOEXEC", errno);
  return copy;
}

struct SpawnSettings {
  SpawnSettings() {
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  posix_spawn_file_actions_t actions{};
  posix_spawnattr_t attributes{};
};

}  // namespace

FilePair local_sockets(int type) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, type | SOCK_CLOEXEC, 0, ends.data()) != 0) fail_start("socketpair", errno);
  return {OpenFile(ends[0]), OpenFile(ends[1])};
}

FilePair output_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail_start("pipe2", errno);
  FilePair pair{OpenFile(ends[0]), OpenFile(ends[1])};
  ::fcntl(pair.ours.fd(), F_SETFL, O_NONBLOCK);
  return pair;
}

ChildProcess start_stage_process(const std::vector<std::string>& arguments, const std::vector<int>& files,
                                 int output) {
  std::vector<std::string> words{program_invocation_name, std::string(kStageProcessFlag),
                                 std::to_string(::getpid())};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  SpawnSettings spawn;
  std::vector<OpenFile> copies;
  posix_spawn_file_actions_addopen(&spawn.actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  copies.push_back(copy_above(output));
  posix_spawn_file_actions_adddup2(&spawn.actions, copies.back().fd(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&spawn.actions, copies.back().fd(), STDERR_FILENO);
  int place = kControlFile;
  for (const int file : files) {
    copies.push_back(copy_above(file));
    posix_spawn_file_actions_adddup2(&spawn.actions, copies.back().fd(), place++);
  }
  posix_spawn_file_actions_addclosefrom_np(&spawn.actions, place);

  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&spawn.attributes, &none);
  posix_spawnattr_setsigdefault(&spawn.attributes, &all);
  posix_spawnattr_setpgroup(&spawn.attributes, 0);
  posix_spawnattr_setflags(&spawn.attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);

  pid_t pid = -1;
  const int error =
      ::posix_spawn(&pid, "/proc/self/exe", &spawn.actions, &spawn.attributes, argv.data(), environ);
  if (error != 0) fail_start("posix_spawn", error);
  return ChildProcess(pid);
}

bool OutputLines::read(int file, std::int64_t now_ns) {
  std::array<char, 4096> buffer;
  for (int i = 0; i < 16; ++i) {  // the rest is read next time, so that other processes get their turn
    const ssize_t count = ::read(file, buffer.data(), buffer.size());
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    if (count == 0) return false;
    add({buffer.data(), static_cast<std::size_t>(count)}, now_ns);
  }
  return true;
}

void OutputLines::end(std::int64_t now_ns) {
  if (!rest_.empty()) line(rest_, now_ns);
  rest_.clear();
  if (left_out_ > 0) log::info("{}: {} more lines left out", name_, left_out_);
  left_out_ = 0;
}

void OutputLines::add(std::string_view text, std::int64_t now_ns) {
  while (!text.empty()) {
    const std::size_t newline = text.find('\n');
    const std::string_view part = text.substr(0, newline);
    if (rest_.size() < kLongestLine) rest_ += part.substr(0, kLongestLine - rest_.size());
    if (newline == std::string_view::npos) return;
    line(rest_, now_ns);
    rest_.clear();
    text.remove_prefix(newline + 1);
  }
}

void OutputLines::line(std::string_view text, std::int64_t now_ns) {
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  if (now_ns - second_ns_ >= kSecondNs) {
    if (left_out_ > 0) log::info("{}: {} more lines left out", name_, left_out_);
    second_ns_ = now_ns;
    lines_ = left_out_ = 0;
  }
  if (lines_ >= kLinesASecond) {
    ++left_out_;
    return;
  }
  ++lines_;
  log::info("{}: {}", name_, escaped_text(text));
}

}  // namespace sslv::sandbox
