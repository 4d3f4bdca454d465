// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_log_format.h"
#include "recording/packed_file.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

struct MatchLogIndex;

/// Reads a log of the league, packed (.log.gz) or not (.log), message by message.
class MatchLogReader {
 public:
  /// Throws StorageError, beginning with the path, for what cannot be opened and for what is no such log.
  explicit MatchLogReader(const std::filesystem::path& path);

  /// False at the end, or where nothing more can be read: problem() says why then. What was whole was given
  /// before.
  bool next(LoggedMessage& out);

  /// The next message is the first that came at `time_ns` or later, once none before it did.
  void go_to(std::int64_t time_ns, const MatchLogIndex& index);
  /// The next message is the one at such a place.
  void go_to(const UnpackPlace& message);
  /// The next message is the file's first.
  void go_to_begin();
  /// The next message begins so many unpacked bytes behind the file's beginning.
  void go_to(const MemberPlace& place, std::uint64_t next_offset);
  /// The next message is the first that came at `time_ns` or later. False: that is more than so many unpacked
  /// bytes away, or it was told to stop.
  bool skip_to(std::int64_t time_ns, std::uint64_t max_bytes, const std::stop_token& stop);

  /// See PackedFile.
  void note_places(std::uint64_t every_bytes) { file_.note_places(every_bytes); }
  std::vector<MemberPlace> take_places() { return file_.take_places(); }

  /// Of the last message: unpacked bytes before it, and the last place before it at which reading may begin.
  std::uint64_t message_offset() const { return message_offset_; }
  UnpackPlace place() const { return place_; }

  /// Unpacked bytes before the next message, after next().
  std::uint64_t next_offset() const { return file_.offset(); }

  /// The path, a colon and why the file could not be read to its end; empty when it could.
  const std::string& problem() const { return problem_; }

 private:
  bool read_header();
  bool stop(const std::string& why);

  const std::string name_;
  PackedFile file_;
  std::uint64_t messages_ = 0, message_offset_ = 0;
  UnpackPlace place_;
  std::optional<MessageHeader> header_;  // read already, its message not yet
  std::string problem_;
  bool is_at_end_ = false;
};

}  // namespace sslv
