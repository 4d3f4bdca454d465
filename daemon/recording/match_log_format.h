// SPDX-License-Identifier: Apache-2.0
#pragma once

// The league's log file: the 12 bytes SSL_LOG_FILE and version 1, then messages, each preceded by its receive
// time, type and size; all numbers big-endian (source: github.com/RoboCup-SSL/ssl-go-tools).

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace sslv {

struct LoggedMessage {
  std::int64_t time_ns = 0;  // Unix time at which it was received
  std::int32_t type = 0;
  std::vector<std::byte> bytes;

  static constexpr std::int32_t kVision2010 = 2, kReferee = 3, kVision2014 = 4, kTracker2020 = 5, kIndex = 6;
};

inline constexpr std::string_view kLogMagic = "SSL_LOG_FILE";
inline constexpr std::int32_t kLogVersion = 1;
inline constexpr std::size_t kLogHeaderBytes = 16;      // at the file's beginning
inline constexpr std::size_t kMessageHeaderBytes = 16;  // before each message
/// Limit per message; index messages of other programs can be this large.
inline constexpr std::int32_t kMaxMessageBytes = 1024 * 1024;

/// The largest possible datagram. Larger messages are read but not parsed.
inline constexpr std::size_t kMaxDatagramInLog = 65'507;
/// Valid message times are from 1970 to 2116 (2^62 ns), so that the sum of two does not overflow.
constexpr bool is_log_time(std::int64_t time_ns) {
  return time_ns >= 0 && time_ns < std::int64_t{1} << 62;
}

/// Precedes each message's bytes in the file.
struct MessageHeader {
  std::int64_t time_ns = 0;
  std::int32_t type = 0, size = 0;
};

std::array<std::byte, kLogHeaderBytes> log_header();
std::array<std::byte, kMessageHeaderBytes> message_header(const MessageHeader& header);
MessageHeader read_message_header(std::span<const std::byte, kMessageHeaderBytes> bytes);

/// Appends the 8 bytes of `value` to `out`.
void put_big_endian(std::int64_t value, std::vector<std::byte>& out);

}  // namespace sslv
