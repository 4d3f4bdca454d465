// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <ctime>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

struct TarEntry {
  std::string name;  // its path in the archive
  std::string content;
};

/// The bytes of a .tar.gz with these files.
std::string tar_gz(const std::vector<TarEntry>& entries, std::time_t modified);

/// The files of a .tar.gz, in its order. Throws std::runtime_error with the reason where it is none, or not
/// all of one, holds anything but files, or more than `max_bytes` of them: it stops there.
std::vector<TarEntry> read_tar_gz(std::string_view bytes, std::size_t max_bytes);

}  // namespace sslv
