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

/// Reads a log of the league, packed (.log.gz) or unpacked (.log), message by message. Several logs in one
/// file, as `cat` makes them, are read as one.
class MatchLogReader {
 public:
  /// Throws StorageError, beginning with the path, if the file cannot be opened or is not such a log.
  explicit MatchLogReader(const std::filesystem::path& path);

  /// Reads the next message. False at the end, or if the rest cannot be read; problem() then has the reason.
  /// Earlier calls have returned all intact messages before that place.
  bool next(LoggedMessage& out);

  /// Goes to the first message in file order with a time of `time_ns` or later.
  void go_to(std::int64_t time_ns, const MatchLogIndex& index);
  /// Goes to the message that begins at this place.
  void go_to(const UnpackPlace& message);
  /// Goes to the file's first message.
  void go_to_begin();
  /// Resumes at `place` and skips to the message that begins at `next_offset` unpacked bytes in the file.
  void go_to(const MemberPlace& place, std::uint64_t next_offset);
  /// Skips to the next message with a time of `time_ns` or later. False if it is more than `max_bytes`
  /// unpacked bytes away, and on a stop request.
  bool skip_to(std::int64_t time_ns, std::uint64_t max_bytes, const std::stop_token& stop);

  /// See PackedFile.
  void note_places(std::uint64_t every_bytes) { file_.note_places(every_bytes); }
  std::vector<MemberPlace> take_places() { return file_.take_places(); }

  /// Unpacked bytes before the last message, and the last place before or at that message at which reading
  /// can start.
  std::uint64_t message_offset() const { return message_offset_; }
  UnpackPlace place() const { return place_; }

  /// Unpacked bytes before the next message, after next().
  std::uint64_t next_offset() const { return file_.offset(); }

  /// The path, a colon and why the file could not be read to its end; empty when it could.
  const std::string& problem() const { return problem_; }

 private:
  bool read_header();
  bool skip(std::uint64_t bytes);
  bool stop(const std::string& why);

  const std::string name_;
  PackedFile file_;
  std::uint64_t messages_ = 0, message_offset_ = 0;
  UnpackPlace place_;
  std::optional<MessageHeader> header_;  // header of the next message, if already read
  std::string problem_;
  bool is_at_end_ = false;
};

}  // namespace sslv
