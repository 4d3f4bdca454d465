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

/// Converts a log: to gzip with an index beside it if `to` ends with .log.gz, unpacked with the league's own
/// index at its end if it ends with .log. If a log is damaged, keeps the messages before the damage. `to`
/// must not exist. Throws StorageError.
ConvertedMatchLog convert_match_log(const std::filesystem::path& from, const std::filesystem::path& to);

/// Replaces a damaged log by one with all messages that can be read, and keeps the damaged file as
/// NAME.damaged, which must not exist. Of a log that a MatchLogWriter did not finish, only flushed messages
/// are kept, because the rest may be wrong. Returns what was done, in words. Throws StorageError; the log is
/// then unchanged.
std::string repair_any_log(const std::filesystem::path& log);

}  // namespace sslv
