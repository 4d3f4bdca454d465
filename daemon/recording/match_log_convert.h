// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace sslv {

struct ConvertedMatchLog {
  std::uint64_t messages = 0;
  std::string problem;  // why `from` could not be read to its end; empty when it could
};

/// Converts a log: to gzip with an index beside it if `to` ends with .log.gz, unpacked with the league's own
/// index at its end if it ends with .log. If a log is damaged, keeps the messages before the damage. `to`
/// must not exist. Throws StorageError.
ConvertedMatchLog convert_match_log(const std::filesystem::path& from, const std::filesystem::path& to);

/// Replaces a damaged log of another program by a new one with all messages that can be read, and keeps the
/// damaged file as NAME.damaged, which must not exist. None if the log is whole. Throws StorageError.
std::optional<ConvertedMatchLog> rewrite_match_log(const std::filesystem::path& log);

}  // namespace sslv
