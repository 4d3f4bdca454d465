// SPDX-License-Identifier: Apache-2.0
// libFuzzer: for any file, a match log's reader returns its messages in order or throws a one-line error, and
// no index beside the log makes it read outside the log. The first byte selects how the rest is used: as a
// file, as a log to be packed in two gzip members, or as the index of a valid log. ./run test-long
#include "base/error.h"
#include "fuzz/expect.h"
#include "fuzz/live_bytes.h"
#include "recording/match_log_index.h"
#include "recording/match_log_reader.h"
#include "recording/match_log_writer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include <unistd.h>
#include <zlib.h>

namespace sslv {
namespace {

using Bytes = std::vector<std::byte>;

std::string log_name() {
  static const std::string name = "/dev/shm/ssl-visiond-fuzz-" + std::to_string(getpid()) + ".log.gz";
  return name;
}

void write_bytes(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void pack(std::span<const std::byte> bytes, Bytes& out) {
  z_stream zlib{};
  if (deflateInit2(&zlib, 1, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY) != Z_OK) return;
  std::vector<Bytef> room(deflateBound(&zlib, bytes.size()));
  zlib.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));  // zlib only reads it
  zlib.avail_in = static_cast<uInt>(bytes.size());
  zlib.next_out = room.data();
  zlib.avail_out = static_cast<uInt>(room.size());
  deflate(&zlib, Z_FINISH);
  const auto packed = std::as_bytes(std::span(room).first(room.size() - zlib.avail_out));
  out.insert(out.end(), packed.begin(), packed.end());
  deflateEnd(&zlib);
}

/// Reads all messages; returns their number.
std::size_t count_messages(MatchLogReader& reader) {
  LoggedMessage message;
  std::size_t count = 0;
  std::uint64_t before = 0;
  for (; reader.next(message); ++count) {
    expect(message.bytes.size() <= static_cast<std::size_t>(kMaxMessageBytes), "a message without a limit");
    expect(count == 0 || reader.message_offset() > before, "a message before the last one");
    before = reader.message_offset();
  }
  return count;
}

void read_log() {
  MatchLogReader reader(log_name());
  const std::size_t count = count_messages(reader);
  const std::string problem = reader.problem();
  expect(problem.empty() || problem.starts_with(log_name()), "a problem that names no file");
  reader.go_to_begin();
  expect(count_messages(reader) == count, "another number of messages the second time");
  const MatchLogIndex index = make_match_log_index(log_name());
  std::uint64_t indexed = 0;
  for (const auto& [type, messages] : index.messages) indexed += messages;
  expect(indexed == count, "an index of another number of messages");
  for (const std::int64_t time_ns : {index.first_ns, index.last_ns, std::int64_t{0}}) {
    reader.go_to(time_ns, index);
    LoggedMessage message;
    if (reader.next(message)) expect(message.time_ns >= time_ns, "a message that came before");
  }
  try {
    if (repair_match_log(log_name()).is_other) return;
    MatchLogReader repaired(log_name());
    count_messages(repaired);
    expect(repaired.problem().empty(), "repaired, and not whole");
  } catch (const StorageError& error) {
    expect(std::string(error.what()).starts_with(log_name()), "an error that names no file");
  }
}

/// A log of a few messages, always the same.
Bytes small_log() {
  Bytes bytes;
  const auto head = log_header();
  bytes.insert(bytes.end(), head.begin(), head.end());
  for (std::int64_t i = 0; i < 20; ++i) {
    const auto message = message_header({i * 1'000'000'000, LoggedMessage::kVision2014, 3});
    bytes.insert(bytes.end(), message.begin(), message.end());
    bytes.insert(bytes.end(), 3, std::byte{7});
  }
  return bytes;
}

void read_index(std::span<const std::byte> json) {
  write_bytes(log_name(), small_log());
  write_bytes(index_file_of(log_name()), json);
  if (const auto index = read_match_log_index(log_name())) {
    MatchLogReader reader(log_name());
    LoggedMessage message;
    for (const std::int64_t time_ns : {std::int64_t{0}, std::int64_t{7'500'000'000}, index->last_ns}) {
      reader.go_to(time_ns, *index);
      while (reader.next(message)) {
      }
    }
  }
  std::filesystem::remove(index_file_of(log_name()));
}

}  // namespace
}  // namespace sslv

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace sslv;
  if (size == 0) return 0;
  const LiveBytes live(kMaxLiveBytes);
  const auto input = std::as_bytes(std::span(bytes + 1, size - 1));
  try {
    if (bytes[0] % 3 == 0) {
      write_bytes(log_name(), input);
      read_log();
    } else if (bytes[0] % 3 == 1) {
      Bytes packed;
      const std::size_t first = std::min<std::size_t>(input.size(), bytes[0]);
      pack(input.first(first), packed);
      pack(input.subspan(first), packed);
      write_bytes(log_name(), packed);
      read_log();
    } else {
      read_index(input);
    }
  } catch (const StorageError& error) {
    expect(std::string(error.what()).starts_with(log_name()), "an error that names no file");
  }
  std::filesystem::remove(log_name());
  return 0;
}
