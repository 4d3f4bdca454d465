// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

struct TarEntry {
  std::string name;  // path in the archive
  std::string content;
};

/// Returns a .tar.gz of these files. Throws std::runtime_error when stopped.
std::string tar_gz(const std::vector<TarEntry>& entries, std::time_t modified,
                   const std::stop_token& stop = {});

/// The bytes of a .tar before and after the content of its last file.
struct TarAround {
  std::string before, after;
};

/// Returns the bytes of a .tar before and after its last file, which has `size` bytes and is too large to
/// hold in memory. `entries`: the files before it.
TarAround tar_around(const std::vector<TarEntry>& entries, const std::string& name, std::uint64_t size,
                     std::time_t modified);

/// Returns the files of a .tar.gz in archive order. Takes at most `max_bytes` of memory, which limits the
/// unpacked archive, and a little for each file. Throws std::runtime_error with the reason if the archive is
/// larger, invalid, truncated or contains anything but whole plain files, and when stopped.
std::vector<TarEntry> read_tar_gz(std::string_view bytes, std::size_t max_bytes,
                                  const std::stop_token& stop = {});

}  // namespace sslv
