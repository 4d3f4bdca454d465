// SPDX-License-Identifier: Apache-2.0
// Starts something that leaves its process group and has all of its files.
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
    for (int file = 0; file < 3; ++file) close(file);  // who runs the tests waits for their end
    alarm(30);
    for (;;) pause();
  }
  return waitpid(child, nullptr, 0);
}();

SSLV_STAGES(sslv::stage<Nothing>("leaves_child", ""))
