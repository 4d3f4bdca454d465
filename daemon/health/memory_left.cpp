// SPDX-License-Identifier: Apache-2.0
#include "health/memory_left.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

namespace sslv {
namespace {

namespace fs = std::filesystem;

/// Number in a file; none if the file is missing or contains "max".
std::optional<std::uint64_t> number_in(const fs::path& file) {
  std::ifstream in(file);
  std::uint64_t value = 0;
  if (in >> value) return value;
  return std::nullopt;
}

std::uint64_t available_bytes(const fs::path& meminfo) {
  std::ifstream in(meminfo);
  for (std::string line; std::getline(in, line);) {
    constexpr const char* kName = "MemAvailable:";
    if (line.starts_with(kName)) return std::stoull(line.substr(std::string(kName).size())) * 1024;
  }
  return std::numeric_limits<std::uint64_t>::max();
}

/// Memory that a group uses and cannot release at once. The group can release cached file content, but not
/// shared memory, which the kernel counts as file content.
std::uint64_t used_bytes(const fs::path& group) {
  const std::uint64_t current = number_in(group / "memory.current").value_or(0);
  std::uint64_t files = 0, memory_files = 0;
  std::ifstream in(group / "memory.stat");
  std::string name;
  for (std::uint64_t value = 0; in >> name >> value;) {
    if (name == "file") files = value;
    if (name == "shmem") memory_files = value;
  }
  return current - std::min(current, files - std::min(files, memory_files));
}

}  // namespace

std::uint64_t memory_left_bytes(const fs::path& root) {
  std::uint64_t left = available_bytes(root / "proc/meminfo");
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (!line.starts_with("0::/")) continue;  // control groups of version 1 have no such limits
    const fs::path top = root / "sys/fs/cgroup";
    // The last group has an empty path: the root group or, in a container, the container's own group.
    for (fs::path group = line.substr(4);; group = group.parent_path()) {
      for (const char* limit : {"memory.high", "memory.max"}) {
        const auto most = number_in(top / group / limit);
        if (!most) continue;
        const std::uint64_t used = used_bytes(top / group);
        left = std::min(left, *most - std::min(*most, used));
      }
      if (group.empty()) break;
    }
  }
  return left;
}

std::uint64_t memory_left_bytes() {
  return memory_left_bytes("/");
}

}  // namespace sslv
