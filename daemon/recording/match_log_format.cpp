// SPDX-License-Identifier: Apache-2.0
#include "recording/match_log_format.h"

#include <algorithm>

namespace sslv {
namespace {

template <class Integer>
void write(Integer value, std::byte* out) {
  for (std::size_t i = sizeof value; i-- > 0; value = static_cast<Integer>(value >> 8))
    out[i] = std::byte(value);
}

template <class Integer>
Integer read(const std::byte* bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(Integer); ++i)
    value = value << 8U | std::to_integer<std::uint64_t>(bytes[i]);
  return static_cast<Integer>(value);
}

}  // namespace

std::array<std::byte, kLogHeaderBytes> log_header() {
  std::array<std::byte, kLogHeaderBytes> out{};
  std::ranges::transform(kLogMagic, out.begin(), [](char c) { return std::byte(c); });
  write(kLogVersion, out.data() + kLogMagic.size());
  return out;
}

std::array<std::byte, kMessageHeaderBytes> message_header(const MessageHeader& header) {
  std::array<std::byte, kMessageHeaderBytes> out{};
  write(header.time_ns, out.data());
  write(header.type, out.data() + 8);
  write(header.size, out.data() + 12);
  return out;
}

MessageHeader read_message_header(std::span<const std::byte, kMessageHeaderBytes> bytes) {
  return {read<std::int64_t>(bytes.data()), read<std::int32_t>(bytes.data() + 8),
          read<std::int32_t>(bytes.data() + 12)};
}

void put_big_endian(std::int64_t value, std::vector<std::byte>& out) {
  out.resize(out.size() + sizeof value);
  write(value, out.data() + out.size() - sizeof value);
}

}  // namespace sslv
