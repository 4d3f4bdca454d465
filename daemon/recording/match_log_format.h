// SPDX-License-Identifier: Apache-2.0
#pragma once

// The log file of the league: the 12 bytes SSL_LOG_FILE and version 1, then messages, each with the time at
// which it was received, its type and its size; all numbers big-endian (github.com/RoboCup-SSL/ssl-go-tools
// describes it).

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace sslv {

/// A message of a log.
struct LoggedMessage {
  std::int64_t time_ns = 0;  // Unix time at which it was received
  std::int32_t type = 0;
  std::vector<std::byte> bytes;

  static constexpr std::int32_t kVision2010 = 2, kReferee = 3, kVision2014 = 4, kTracker2020 = 5, kIndex = 6;
};

inline constexpr std::string_view kLogMagic = "SSL_LOG_FILE";
inline constexpr std::int32_t kLogVersion = 1;
inline constexpr std::size_t kLogHeaderBytes = 16;      // of the file
inline constexpr std::size_t kMessageHeaderBytes = 16;  // of each message
/// An index of other programs may be so large.
inline constexpr std::int32_t kMaxMessageBytes = 1024 * 1024;

/// No datagram is larger than this; what is, is read but not understood.
inline constexpr std::size_t kMaxDatagramInLog = 65'507;
/// Times of messages: from 1970 on, and sums of them stay numbers. In the year 2115 this ends.
constexpr bool is_log_time(std::int64_t time_ns) {
  return time_ns >= 0 && time_ns < std::int64_t{1} << 62;
}

/// What stands before a message's bytes.
struct MessageHeader {
  std::int64_t time_ns = 0;
  std::int32_t type = 0, size = 0;
};

std::array<std::byte, kLogHeaderBytes> log_header();
std::array<std::byte, kMessageHeaderBytes> message_header(const MessageHeader& header);
MessageHeader read_message_header(std::span<const std::byte, kMessageHeaderBytes> bytes);

/// Adds `value` to `out`, its highest byte first.
void put_big_endian(std::int64_t value, std::vector<std::byte>& out);

}  // namespace sslv
