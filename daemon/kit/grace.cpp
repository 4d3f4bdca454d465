// SPDX-License-Identifier: Apache-2.0
#include "kit/grace.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

namespace sslv {

std::int64_t grace_ns(pid_t process, std::int64_t most_ns) {
  std::ifstream file(fmt::format("/proc/{}/schedstat", process));
  std::int64_t ran = 0, waited = 0;
  if (!(file >> ran >> waited)) return 0;  // it has ended, or the kernel does not tell
  return std::clamp<std::int64_t>(waited, 0, most_ns);
}

}  // namespace sslv
