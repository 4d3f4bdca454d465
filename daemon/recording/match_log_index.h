// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_events.h"
#include "recording/packed_file.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

/// A place of a log at which reading may begin; there is a message.
struct MatchLogPoint {
  UnpackPlace place;
  std::uint64_t messages = 0;      // before it
  std::int64_t all_before_ns = 0;  // the latest time of those

  bool operator==(const MatchLogPoint&) const = default;
};

/// What a log holds, and where. It stands beside the log (docs/recording.md says how) and can always be made
/// again.
struct MatchLogIndex {
  std::uint64_t file_bytes = 0;  // of the log that it belongs to
  std::uint32_t end_sum = 0;     // CRC-32 of the log's last bytes, so that a log that was replaced is noticed
  std::uint64_t unpacked_bytes = 0;
  std::map<std::int32_t, std::uint64_t> messages;  // by type
  std::int64_t first_ns = 0, last_ns = 0;          // Unix times of the first message, and the latest of all
  std::vector<MatchLogPoint> points;               // in the file's order
  std::vector<MatchEvent> events;
  std::string problem;  // why the log could not be read to its end; empty when it could

  bool operator==(const MatchLogIndex&) const = default;
};

/// More of a log is not read: it is no match, or made to fill memory and time.
inline constexpr std::uint64_t kMaxUnpackedBytes = std::uint64_t{64} << 30U;

/// Adds a log's messages one after the other. However long the log is, its index stays small: of very many
/// points every other one is left out.
class MatchLogIndexMaker {
 public:
  /// `offset`: unpacked bytes before the message; `place`: the last one before it at which reading may begin.
  void add(const LoggedMessage& message, std::uint64_t offset, const UnpackPlace& place);
  /// What there is so far; all but what is said of the file.
  const MatchLogIndex& index() const { return index_; }
  MatchLogIndex take() { return std::move(index_); }

 private:
  MatchLogIndex index_;
  MatchEventFinder events_;
  std::uint64_t messages_ = 0;
  std::uint64_t between_points_ = 512 * 1024;  // unpacked bytes, at least
};

/// Reads the whole log. Throws StorageError as MatchLogReader does, and when it was told to stop.
MatchLogIndex make_match_log_index(const std::filesystem::path& log, const std::stop_token& stop = {});

/// NAME.index beside NAME.
std::filesystem::path index_file_of(const std::filesystem::path& log);

/// The index beside a log; none where there is none, or it belongs to other bytes.
std::optional<MatchLogIndex> read_match_log_index(const std::filesystem::path& log);
/// Puts it there. Throws StorageError.
void write_match_log_index(const std::filesystem::path& log, const MatchLogIndex& index);

/// The index beside the log; made and, where the folder allows it, put there if there is none. Throws as
/// make_match_log_index() does.
MatchLogIndex match_log_index(const std::filesystem::path& log, const std::stop_token& stop = {});

/// Sets what an index says of its file's size and end. Throws StorageError.
void sign_match_log_index(const std::filesystem::path& log, MatchLogIndex& index);

}  // namespace sslv
