// SPDX-License-Identifier: Apache-2.0
#include "net/vision_log.h"

#include "base/error.h"

#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace sslv {
namespace {

constexpr std::string_view kMagic = "SSL_LOG_FILE";
constexpr std::int32_t kVersion = 1;
constexpr std::int32_t kLargest = 1024 * 1024;

template <class Integer>
bool read_big_endian(std::istream& in, Integer& value) {
  std::array<unsigned char, sizeof value> bytes{};
  if (!in.read(reinterpret_cast<char*>(bytes.data()), bytes.size())) return false;
  std::uint64_t read = 0;
  for (const unsigned char byte : bytes) read = read << 8 | byte;
  value = static_cast<Integer>(read);
  return true;
}

}  // namespace

VisionLogReader::VisionLogReader(std::istream& in, std::string name) : in_(in), name_(std::move(name)) {
  std::string magic(kMagic.size(), '\0');
  std::int32_t version = 0;
  if (!in_.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != kMagic ||
      !read_big_endian(in_, version))
    throw StorageError(fmt::format("{}: is no log of the league: it does not begin with {}", name_, kMagic));
  if (version != kVersion)
    throw StorageError(
        fmt::format("{}: version {} of logs is not known; expected {}", name_, version, kVersion));
}

bool VisionLogReader::next(LoggedMessage& out) {
  if (!read_big_endian(in_, out.time_ns)) return false;
  std::int32_t size = 0;
  ++messages_;
  const auto refuse = [&](const char* why) {
    throw StorageError(fmt::format("{}: message {} {}", name_, messages_, why));
  };
  if (!read_big_endian(in_, out.type) || !read_big_endian(in_, size)) refuse("is cut off");
  if (size < 0 || size > kLargest) refuse("is larger than any packet");
  out.bytes.resize(static_cast<std::size_t>(size));
  if (!in_.read(reinterpret_cast<char*>(out.bytes.data()), size)) refuse("is cut off");
  return true;
}

}  // namespace sslv
