// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

namespace sslv {

/// How many bytes this process may still take before the computer, or a limit that systemd or somebody else
/// set for it, is short of memory: memory_high or memory_max of its control group and those above it.
std::uint64_t memory_left_bytes();

/// The same with /proc and /sys/fs/cgroup below `root`, for tests.
std::uint64_t memory_left_bytes(const std::filesystem::path& root);

}  // namespace sslv
