// SPDX-License-Identifier: Apache-2.0
#include "support/child_process.h"

#include "support/patience.h"

#include <csignal>
#include <cstdlib>
#include <stdexcept>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sslv::test {

namespace {

/// Passes files on like the service manager (sd_listen_fds(3)); called in the child before exec.
void hand_over(const std::vector<KeptFile>& kept) {
  if (kept.empty()) return;
  constexpr int kFirst = 3, kOutOfTheWay = 200;
  std::vector<int> files;
  std::string names;
  for (const KeptFile& one : kept) {
    files.push_back(::fcntl(one.file.fd(), F_DUPFD_CLOEXEC, kOutOfTheWay));
    names += (names.empty() ? "" : ":") + one.name;
  }
  for (std::size_t i = 0; i < files.size(); ++i) ::dup2(files[i], kFirst + static_cast<int>(i));
  ::setenv("LISTEN_PID", std::to_string(::getpid()).c_str(), 1);
  ::setenv("LISTEN_FDS", std::to_string(files.size()).c_str(), 1);
  ::setenv("LISTEN_FDNAMES", names.c_str(), 1);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& words, const std::vector<std::string>& environment,
                           const std::vector<KeptFile>& kept)
    : name_(words.at(0)) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe for " + name_);
  pid_ = ::fork();
  if (pid_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // so that it does not outlive a crashed test
    ::dup2(ends[1], STDOUT_FILENO);
    ::dup2(ends[1], STDERR_FILENO);
    for (const std::string& entry : environment) ::putenv(const_cast<char*>(entry.c_str()));
    hand_over(kept);
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  pipe_ = ends[0];
  if (pid_ < 0) throw std::runtime_error("cannot start " + name_);
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ::close(pipe_);
}

bool ChildProcess::read_some(std::chrono::steady_clock::time_point deadline) {
  const auto left =
      std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
  pollfd waiting{pipe_, POLLIN, 0};
  if (left.count() <= 0 || ::poll(&waiting, 1, static_cast<int>(left.count())) <= 0) {
    throw std::runtime_error(name_ + ": time ran out; it printed:\n" + output_);
  }
  char buffer[4096];
  const ssize_t n = ::read(pipe_, buffer, sizeof buffer);
  if (n <= 0) return false;
  output_.append(buffer, static_cast<std::size_t>(n));
  return true;
}

std::string ChildProcess::wait_for_line(const std::string& text) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    std::size_t end;
    while ((end = output_.find('\n', searched_)) != std::string::npos) {
      const std::string line = output_.substr(searched_, end - searched_);
      searched_ = end + 1;
      if (line.find(text) != std::string::npos) return line;
    }
    if (!read_some(deadline))
      throw std::runtime_error(name_ + " ended before \"" + text + "\"; it printed:\n" + output_);
  }
}

void ChildProcess::send_signal(int signal) const {
  if (pid_ > 0) ::kill(pid_, signal);
}

int ChildProcess::wait_for_exit() {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (read_some(deadline)) {
  }
  int status = 0;
  if (pid_ > 0) ::waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

Finished run_to_end(const std::vector<std::string>& words, const std::vector<std::string>& environment) {
  ChildProcess child(words, environment);
  const int exit_code = child.wait_for_exit();
  return {exit_code, child.output()};
}

}  // namespace sslv::test
