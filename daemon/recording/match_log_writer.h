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

/// Writes a log of the league as gzip, for every tool that reads such logs. Reading may begin at many places
/// of it: it is made of members, of about a MiB of messages each, and an index stands beside it in the end.
/// What was flushed survives a power cut; repair_match_log() makes the file a whole one again.
class MatchLogWriter {
 public:
  /// Unpacked bytes of a member.
  static constexpr std::size_t kMemberBytes = 1024 * 1024;

  /// Makes the file, which must not be there yet. Throws StorageError.
  explicit MatchLogWriter(const std::filesystem::path& path);
  /// Without finish() the file stays as after a power cut.
  ~MatchLogWriter();

  /// Into memory, and into the file what is ready. Messages of more than kMaxMessageBytes are left out.
  /// Throws StorageError.
  void add(std::int64_t time_ns, std::int32_t type, std::span<const std::byte> message);
  /// When it returns, all that was added is on the disk. Throws StorageError.
  void flush();
  /// Likewise, and the file is complete; nothing may be added any more. It has its index, unless that cannot
  /// be written: it can be made again at any time. Throws StorageError.
  void finish();

  std::uint64_t bytes() const;  // that went into the file
  const MatchLogIndex& index() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// What repair_match_log() did.
struct RepairedMatchLog {
  bool was_whole = true;
  std::uint64_t removed_bytes = 0;  // of the file, at its end
};

/// Makes a packed log whole that a MatchLogWriter did not finish: what was flushed stays, what came after it
/// goes. May be interrupted and called again. Throws StorageError for what is no such log, and when it is
/// told to stop; the log then stays as it is.
RepairedMatchLog repair_match_log(const std::filesystem::path& path, const std::stop_token& stop = {});

}  // namespace sslv
