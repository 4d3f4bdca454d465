// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>
#include <string>
#include <vector>

namespace sslv {

struct TarEntry {
  std::string name;  // its path in the archive
  std::string content;
};

/// The bytes of a .tar.gz with these files.
std::string tar_gz(const std::vector<TarEntry>& entries, std::time_t modified);

}  // namespace sslv
