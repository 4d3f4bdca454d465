// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace sslv {

/// Bytes that this process may still allocate before it exceeds the computer's memory or a limit set by
/// systemd or otherwise (memory.high or memory.max of the process's control group and of the groups above).
std::uint64_t memory_left_bytes();

/// The same with /proc and /sys/fs/cgroup below `root`, for tests.
std::uint64_t memory_left_bytes(const std::filesystem::path& root);

}  // namespace sslv
