// SPDX-License-Identifier: Apache-2.0
#include "kit/child_process.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace sslv {

ChildProcess::ChildProcess(pid_t pid) : pid_(pid) {
  ::setpgid(pid, pid);  // harmless if the child has also called it; fails after the child's exec
  end_ = OpenFile(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
  if (end_.is_open()) return;
  const int why = errno;
  end();
  throw std::system_error(why, std::system_category(), "pidfd_open");
}

ChildProcess::~ChildProcess() {
  end();
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), end_(std::move(other.end_)) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  std::swap(pid_, other.pid_);
  std::swap(end_, other.end_);
  return *this;
}

bool ChildProcess::has_ended(int within_ms) const {
  pollfd ended{end_.fd(), POLLIN, 0};
  return ::poll(&ended, 1, within_ms) == 1;
}

std::int64_t ChildProcess::grace_ns(std::int64_t most_ns) const {
  std::ifstream file(fmt::format("/proc/{}/schedstat", pid_));
  std::int64_t ran = 0, waited = 0;
  if (!(file >> ran >> waited)) return 0;  // the process has ended, or the kernel lacks schedstat
  return std::clamp<std::int64_t>(waited, 0, most_ns);
}

void ChildProcess::kill() noexcept {
  if (pid_ <= 0) return;
  ::kill(-pid_, SIGKILL);
  ::kill(pid_, SIGKILL);  // the process may not be in its group yet
}

int ChildProcess::end() noexcept {
  int status = 0;
  if (pid_ <= 0) return status;
  kill();
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  end_ = OpenFile();
  return status;
}

std::string end_text(int status) {
  if (WIFSIGNALED(status)) return fmt::format("was killed by signal {}", WTERMSIG(status));
  return fmt::format("exited with code {}", WEXITSTATUS(status));
}

}  // namespace sslv
