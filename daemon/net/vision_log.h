// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <string>
#include <vector>

namespace sslv {

/// A message of a log of the league's logger.
struct LoggedMessage {
  std::int64_t time_ns = 0;  // Unix time at which it was received
  std::int32_t type = 0;
  std::vector<std::byte> bytes;

  static constexpr std::int32_t kReferee2013 = 3, kVision2014 = 4, kTracker2020 = 5;
};

/// Reads such a log, message by message (github.com/RoboCup-SSL/ssl-go-tools describes the format: a header
/// "SSL_LOG_FILE" and version 1, then for each message time, type and size, big-endian).
class VisionLogReader {
 public:
  /// `in` must outlive this; `name` is for messages. Throws StorageError for what is no such log.
  VisionLogReader(std::istream& in, std::string name);
  /// False at the end. Throws StorageError for a message that is cut off or larger than any datagram.
  bool next(LoggedMessage& out);

 private:
  std::istream& in_;
  const std::string name_;
  std::uint64_t messages_ = 0;
};

}  // namespace sslv
