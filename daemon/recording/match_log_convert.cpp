// SPDX-License-Identifier: Apache-2.0
#include "recording/match_log_convert.h"

#include "base/error.h"
#include "base/log.h"
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
#include <sys/stat.h>
#include <unistd.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

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

ConvertedMatchLog write_log(const fs::path& from, const fs::path& to, bool is_packed) {
  MatchLogReader reader(from);
  if (is_packed) {
    MatchLogWriter writer(to);
    auto out = copy_messages(reader, [&](const LoggedMessage& message) {
      writer.add(message.time_ns, message.type, message.bytes);
    });
    writer.finish();
    return out;
  }
  PlainLog plain(to);
  auto out = copy_messages(reader, [&](const LoggedMessage& message) { plain.add(message); });
  plain.finish();
  return out;
}

std::string problem_of(const fs::path& log) {
  MatchLogReader reader(log);
  for (LoggedMessage message; reader.next(message);) {
  }
  return reader.problem();
}

/// Gives `to` the mode and, if permitted, the owner of `from`.
void copy_rights(const fs::path& from, const fs::path& to) {
  struct stat about {};
  if (::stat(from.c_str(), &about) != 0) return;
  constexpr mode_t kRights = 0777;
  ::chmod(to.c_str(), about.st_mode & kRights);
  if (::chown(to.c_str(), about.st_uid, about.st_gid) != 0)
    log::info("{}: belongs to you now", from.string());
}

}  // namespace

ConvertedMatchLog convert_match_log(const fs::path& from, const fs::path& to) {
  const std::string name = to.string();
  if (!name.ends_with(".log") && !name.ends_with(".log.gz"))
    throw StorageError(fmt::format("{}: expected a name that ends with .log or .log.gz", name));
  if (fs::exists(to)) throw StorageError(fmt::format("{}: already exists", name));
  return write_log(from, to, name.ends_with(".log.gz"));
}

std::string repair_any_log(const fs::path& log) {
  const fs::path damaged = log.string() + ".damaged", rewritten = log.string() + ".rewritten";
  if (fs::exists(damaged)) throw StorageError(fmt::format("{}: already exists", damaged.string()));
  const std::string problem = problem_of(log);
  if (problem.empty()) return "is whole";
  const auto remove = [&] {
    std::error_code ignored;
    for (const fs::path& one : {rewritten, index_file_of(rewritten)}) fs::remove(one, ignored);
  };
  remove();
  try {
    fs::copy_file(log, rewritten);
    if (repair_match_log(rewritten).is_other) {
      remove();
      write_log(log, rewritten, log.extension() == ".gz");
    }
    copy_rights(log, rewritten);
    fs::rename(log, damaged);
    fs::rename(rewritten, log);
  } catch (const fs::filesystem_error& error) {
    remove();
    throw StorageError(fmt::format("{}: {}", log.string(), error.code().message()));
  } catch (...) {
    remove();
    throw;
  }
  remove();  // the index, which has the other name
  std::error_code ignored;
  fs::remove(index_file_of(log), ignored);  // it is made again
  return fmt::format("was repaired ({}); the damaged file is {}", problem, damaged.string());
}

}  // namespace sslv
