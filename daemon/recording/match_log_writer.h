// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_log_index.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>

namespace sslv {

/// Writes a log of the league as gzip, which every tool for such logs can read. Reading can start at many
/// places: each gzip member holds about 1 MiB of messages, and finish() writes an index beside the log.
/// Flushed data survives a power cut; repair_match_log() then completes the file.
class MatchLogWriter {
 public:
  /// A gzip member ends at the first message boundary after this many unpacked bytes.
  static constexpr std::size_t kMemberBytes = 1024 * 1024;

  /// Creates the file, which must not exist. Throws StorageError.
  explicit MatchLogWriter(const std::filesystem::path& path);
  /// Without finish() the file is left as after a power cut.
  ~MatchLogWriter();

  /// Compresses the message in memory and writes the compressed output so far to the file. Drops messages of
  /// more than kMaxMessageBytes. Throws StorageError.
  void add(std::int64_t time_ns, std::int32_t type, std::span<const std::byte> message);
  /// On return, all added messages are on the disk. Throws StorageError, also if the file was removed or
  /// replaced.
  void flush();
  /// Writes all added messages to the disk and completes the file; add() must not be called afterwards. Also
  /// writes the index; if that fails, it only logs a warning, as the index can be made again at any time.
  /// Throws StorageError.
  void finish();

  std::uint64_t bytes() const;  // written to the file
  const MatchLogIndex& index() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

struct RepairedMatchLog {
  bool was_whole = true;
  bool is_other = false;            // incomplete, but not a MatchLogWriter's: left unchanged
  std::uint64_t removed_bytes = 0;  // from the file's end
};

/// Completes a packed log that a MatchLogWriter did not finish: keeps everything up to the last flush and
/// removes the rest, which a power cut may have changed. Can be interrupted and called again. Throws
/// StorageError on a stop request, which leaves the log unchanged.
RepairedMatchLog repair_match_log(const std::filesystem::path& path, const std::stop_token& stop = {});

}  // namespace sslv
