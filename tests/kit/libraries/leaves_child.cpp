// SPDX-License-Identifier: Apache-2.0
// Starts a process that leaves the process group and keeps all open files.
#include <kit/stages.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {
class Nothing {
 public:
  struct Params {
    static constexpr auto fields() { return std::tuple{}; }
  };
  void process(const Params&, const sslv::BallList&) noexcept {}
};
}  // namespace

static const int kLeft = [] {
  const pid_t child = fork();
  if (child == 0) {
    setsid();
    if (fork() != 0) _exit(0);
    for (int file = 0; file < 3; ++file) close(file);  // the test runner waits until these are closed
    alarm(30);
    for (;;) pause();
  }
  return waitpid(child, nullptr, 0);
}();

SSLV_STAGES(sslv::stage<Nothing>("leaves_child", ""))
