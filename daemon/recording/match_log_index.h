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

/// A place in a log at which reading can start; a message begins there.
struct MatchLogPoint {
  UnpackPlace place;
  std::uint64_t messages = 0;      // number of messages before this point
  std::int64_t all_before_ns = 0;  // latest time of those messages

  bool operator==(const MatchLogPoint&) const = default;
};

/// Overview of a log's contents, and points at which reading can start. Stored in a file beside the log
/// (format: docs/recording.md); can be made from the log again at any time.
struct MatchLogIndex {
  std::uint64_t file_bytes = 0;  // size of the log
  std::uint32_t end_sum = 0;     // CRC-32 of the log's last 4096 bytes, to detect a replaced log
  std::uint64_t unpacked_bytes = 0;
  std::map<std::int32_t, std::uint64_t> messages;  // number of messages by type
  std::int64_t first_ns = 0, last_ns = 0;          // Unix time of the first message; latest Unix time
  std::vector<MatchLogPoint> points;               // in the file's order
  std::vector<MatchEvent> events;
  std::uint32_t tracker_sum = 0;  // CRC-32 of the uuid of the first tracker from which events are; 0: none
  std::string problem;            // why the log could not be read to its end; empty when it could

  bool operator==(const MatchLogIndex&) const = default;
};

/// Reading a log stops at this size: a larger log is not a match, or was made to exhaust memory and time.
inline constexpr std::uint64_t kMaxUnpackedBytes = std::uint64_t{64} << 30U;

/// Builds the index of a log from its messages in file order. To keep the index small, it removes every other
/// point when there are too many.
class MatchLogIndexMaker {
 public:
  /// `offset`: unpacked bytes before the message; `place`: the last place before or at the message at which
  /// reading can start.
  void add(const LoggedMessage& message, std::uint64_t offset, const UnpackPlace& place);
  /// The index so far, without file_bytes, end_sum and problem.
  const MatchLogIndex& index() const { return index_; }
  MatchLogIndex take() { return std::move(index_); }

 private:
  MatchLogIndex index_;
  MatchEventFinder events_;
  std::uint64_t messages_ = 0;
  std::uint64_t between_points_ = 512 * 1024;  // minimum distance, in unpacked bytes
};

/// MatchLogIndex::tracker_sum of a tracker.
std::uint32_t tracker_sum_of(std::string_view uuid);

/// Reads the whole log. Throws StorageError like MatchLogReader, and on a stop request.
MatchLogIndex make_match_log_index(const std::filesystem::path& log, const std::stop_token& stop = {});

/// NAME.index beside NAME.
std::filesystem::path index_file_of(const std::filesystem::path& log);

/// The index beside a log; none if it is missing, invalid, or of another version of the log.
std::optional<MatchLogIndex> read_match_log_index(const std::filesystem::path& log);
/// Writes the index beside its log. Throws StorageError.
void write_match_log_index(const std::filesystem::path& log, const MatchLogIndex& index);

/// Returns the index beside the log. If there is no valid index, makes one and writes it there if the folder
/// is writable. Throws like make_match_log_index().
MatchLogIndex match_log_index(const std::filesystem::path& log, const std::stop_token& stop = {});

/// Sets file_bytes and end_sum of an index from its log. Throws StorageError.
void sign_match_log_index(const std::filesystem::path& log, MatchLogIndex& index);

}  // namespace sslv
