// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <sys/types.h>

namespace sslv {

/// How much later than its limit this process may be done, `most_ns` at most: it wanted a processor for so
/// long and got none. 0 once it has ended and was waited for.
std::int64_t grace_ns(pid_t process, std::int64_t most_ns);

}  // namespace sslv
