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
  std::string name;  // its path in the archive
  std::string content;
};

/// The bytes of a .tar.gz with these files. Throws std::runtime_error once it is told to stop.
std::string tar_gz(const std::vector<TarEntry>& entries, std::time_t modified,
                   const std::stop_token& stop = {});

/// What stands in a .tar around the bytes of its last file.
struct TarAround {
  std::string before, after;
};

/// Of a .tar with these files and a last one of so many bytes, which is too large to be held in memory.
TarAround tar_around(const std::vector<TarEntry>& entries, const std::string& name, std::uint64_t size,
                     std::time_t modified);

/// The files of a .tar.gz, in its order. Takes no more memory than `max_bytes`, which is the most that the
/// archive may have unpacked, and little for each file. Throws std::runtime_error with the reason where it
/// has more, is none or not all of one, or holds anything but whole files. Also once it is told to stop.
std::vector<TarEntry> read_tar_gz(std::string_view bytes, std::size_t max_bytes,
                                  const std::stop_token& stop = {});

}  // namespace sslv
