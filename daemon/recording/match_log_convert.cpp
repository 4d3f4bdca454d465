// SPDX-License-Identifier: Apache-2.0
#include "recording/match_log_convert.h"

#include "base/error.h"
#include "recording/match_log_index.h"
#include "recording/match_log_reader.h"
#include "recording/match_log_writer.h"

#include <algorithm>
#include <fstream>
#include <ios>
#include <span>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace sslv {
namespace {

/// An unpacked log as the league's own tools write it.
class PlainLog {
 public:
  explicit PlainLog(const std::filesystem::path& file) : name_(file.string()), out_(file, std::ios::binary) {
    put(log_header());
  }

  void add(const LoggedMessage& message) {
    offsets_.push_back(offset_);
    put(message_header({message.time_ns, message.type, static_cast<std::int32_t>(message.bytes.size())}));
    put(message.bytes);
  }

  /// Appends the index message: the offsets of all messages, its own distance from the file's end, and a
  /// marker. Throws StorageError.
  void finish() {
    constexpr std::string_view kEnd = "INDEXED";
    std::vector<std::byte> index;
    for (const std::int64_t offset : offsets_) put_big_endian(offset, index);
    const auto size = static_cast<std::int64_t>(index.size() + sizeof(std::int64_t) + kEnd.size());
    put_big_endian(size + static_cast<std::int64_t>(kMessageHeaderBytes), index);
    std::ranges::transform(kEnd, std::back_inserter(index), [](char c) { return std::byte(c); });
    put(message_header({0, LoggedMessage::kIndex, static_cast<std::int32_t>(size)}));
    put(index);
    out_.flush();
    check();
  }

 private:
  void put(std::span<const std::byte> bytes) {
    out_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    offset_ += static_cast<std::int64_t>(bytes.size());
    check();
  }
  void check() const {
    if (!out_) throw StorageError(fmt::format("{}: cannot be written", name_));
  }

  const std::string name_;
  std::ofstream out_;
  std::int64_t offset_ = 0;
  std::vector<std::int64_t> offsets_;
};

template <class Add>
ConvertedMatchLog copy_messages(MatchLogReader& reader, Add add) {
  ConvertedMatchLog out;
  for (LoggedMessage message; reader.next(message); ++out.messages) add(message);
  out.problem = reader.problem();
  return out;
}

}  // namespace

ConvertedMatchLog convert_match_log(const std::filesystem::path& from, const std::filesystem::path& to) {
  const std::string name = to.string();
  MatchLogReader reader(from);
  if (name.ends_with(".log.gz")) {
    MatchLogWriter writer(to);
    auto out = copy_messages(reader, [&](const LoggedMessage& message) {
      writer.add(message.time_ns, message.type, message.bytes);
    });
    writer.finish();
    return out;
  }
  if (!name.ends_with(".log"))
    throw StorageError(fmt::format("{}: expected a name that ends with .log or .log.gz", name));
  if (std::filesystem::exists(to)) throw StorageError(fmt::format("{}: already exists", name));
  PlainLog plain(to);
  auto out = copy_messages(reader, [&](const LoggedMessage& message) { plain.add(message); });
  plain.finish();
  return out;
}

std::optional<ConvertedMatchLog> rewrite_match_log(const std::filesystem::path& log) {
  namespace fs = std::filesystem;
  if (make_match_log_index(log).problem.empty()) return std::nullopt;
  const fs::path damaged = log.string() + ".damaged",
                 rewritten = log.parent_path() / ("rewritten." + log.filename().string());
  if (fs::exists(damaged)) throw StorageError(fmt::format("{}: already exists", damaged.string()));
  const ConvertedMatchLog out = convert_match_log(log, rewritten);
  const auto rename = [](const fs::path& from, const fs::path& to) {
    std::error_code error;
    fs::rename(from, to, error);
    if (error) throw StorageError(fmt::format("{}: cannot be renamed: {}", from.string(), error.message()));
  };
  rename(log, damaged);
  rename(rewritten, log);
  if (fs::exists(index_file_of(rewritten))) rename(index_file_of(rewritten), index_file_of(log));
  return out;
}

}  // namespace sslv
