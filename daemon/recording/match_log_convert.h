// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace sslv {

struct ConvertedMatchLog {
  std::uint64_t messages = 0;
  std::string problem;  // why `from` could not be read to its end; empty when it could
};

/// Writes a log again: packed with an index beside it when `to` ends with .log.gz, plain with the league's
/// own index at its end when it ends with .log. What is whole of a damaged log is kept. `to` must not be
/// there yet. Throws StorageError.
ConvertedMatchLog convert_match_log(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace sslv
