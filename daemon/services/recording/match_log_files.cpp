// SPDX-License-Identifier: Apache-2.0
#include "services/recording/match_log_files.h"

#include "base/error.h"
#include "base/log.h"
#include "recording/match_log_writer.h"
#include "settings/state_folder.h"

#include <algorithm>
#include <ctime>
#include <functional>
#include <system_error>
#include <tuple>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace sslv {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxName = 200;
constexpr int kMaxOfOneName = 1000;

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() > end.size() && text.ends_with(end);
}

fs::path pin_of(const fs::path& log) {
  return log.string() + ".pinned";
}

fs::path unfinished_mark_of(const fs::path& log) {
  return log.string() + ".unfinished";
}

/// No link: that could lead out of the folder.
bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::symlink_status(path, error).type() == fs::file_type::regular;
}

std::uint64_t size_of(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  return error ? 0 : size;
}

}  // namespace

bool is_match_log_name(const std::string& name) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.' || c == ' ';
  };
  return (ends_with(name, ".log") || ends_with(name, ".log.gz")) && name.size() <= kMaxName &&
         name[0] != '.' && std::ranges::all_of(name, is_allowed);
}

MatchLogFiles::MatchLogFiles(fs::path folder) : folder_(std::move(folder)) {}

std::vector<std::string> MatchLogFiles::names() const {
  std::vector<std::string> out;
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (is_match_log_name(name) && is_file(entry->path())) out.push_back(name);
  }
  return out;
}

std::string MatchLogFiles::open_name() const {
  const std::lock_guard lock(mutex_);
  return open_name_;
}

fs::path MatchLogFiles::begin(const std::string& name) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw StorageError(fmt::format("{}: cannot be made: {}", folder_.string(), error.message()));
  const std::string begin = fmt::format("{:%Y-%m-%d_%H-%M}_{}", fmt::gmtime(std::time(nullptr)), name);
  for (int number = 1; number < kMaxOfOneName; ++number) {
    const std::string file = begin + (number > 1 ? fmt::format("_{}", number) : "") + ".log.gz";
    if (fs::exists(folder_ / file, error)) continue;
    {
      const std::lock_guard lock(mutex_);
      open_name_ = file;
    }
    write_file_durably(unfinished_mark_of(folder_ / file), "");
    return folder_ / file;
  }
  throw StorageError(fmt::format("{}: there are too many logs named {}", folder_.string(), begin));
}

void MatchLogFiles::end(bool is_finished) {
  const std::string name = open_name();
  if (is_finished) remove_file(unfinished_mark_of(folder_ / name));
  const std::lock_guard lock(mutex_);
  open_name_.clear();
}

std::optional<MatchLogFile> MatchLogFiles::find(const std::string& name) const {
  if (!is_match_log_name(name)) return std::nullopt;
  std::error_code error;
  const fs::path path = folder_ / name;
  if (!is_file(path)) return std::nullopt;
  MatchLogFile out{.name = name,
                   .bytes = size_of(path),
                   .is_pinned = fs::exists(pin_of(path), error),
                   .index = {},
                   .problem = {}};
  const std::lock_guard lock(mutex_);
  if (const auto known = known_.find(name); known != known_.end() && name != open_name_) {
    out.index = known->second.index;
    out.problem = known->second.problem;
  }
  return out;
}

std::vector<MatchLogFile> MatchLogFiles::list() const {
  std::vector<std::pair<fs::file_time_type, MatchLogFile>> files;
  for (const std::string& name : names()) {
    std::error_code error;
    if (auto file = find(name))
      files.emplace_back(fs::last_write_time(path_of(name), error), *std::move(file));
  }
  std::ranges::sort(files, std::greater{},
                    [](const auto& file) { return std::tie(file.first, file.second.name); });
  std::vector<MatchLogFile> out;
  for (auto& file : files) out.push_back(std::move(file.second));
  return out;
}

void MatchLogFiles::pin(const std::string& name, bool is_pinned) {
  const fs::path pin = pin_of(folder_ / name);
  is_pinned ? write_file_durably(pin, "") : remove_file(pin);
}

bool MatchLogFiles::remove(const std::string& name) {
  if (name == open_name()) return false;
  const fs::path log = folder_ / name;
  remove_file(log);
  remove_file(index_file_of(log));
  remove_file(pin_of(log));
  remove_file(unfinished_mark_of(log));
  const std::lock_guard lock(mutex_);
  known_.erase(name);
  return true;
}

DiskUse MatchLogFiles::disk_use() const {
  DiskUse use;
  for (const std::string& name : names())
    use.used_bytes += size_of(folder_ / name) + size_of(index_file_of(folder_ / name));
  std::error_code error;
  fs::space_info space = fs::space(folder_, error);
  if (error) space = fs::space(folder_.parent_path(), error);  // it is not made yet
  if (!error) use.free_bytes = space.available;
  return use;
}

std::vector<std::string> MatchLogFiles::make_room(std::uint64_t quota_bytes) {
  struct Log {
    fs::file_time_type written;
    std::string name;
    std::uint64_t bytes = 0;
  };
  // By when they were written, not by their names: others put logs here too, and a clock may have been wrong.
  std::vector<Log> logs;
  std::uint64_t used_bytes = 0;
  const std::string open = open_name();
  for (const std::string& name : names()) {
    std::error_code error;
    const fs::path path = folder_ / name;
    const std::uint64_t bytes = size_of(path) + size_of(index_file_of(path));
    used_bytes += bytes;
    if (name != open && !fs::exists(pin_of(path), error))
      logs.push_back({fs::last_write_time(path, error), name, bytes});
  }
  std::ranges::sort(logs, {}, [](const Log& log) { return std::pair(log.written, log.name); });
  std::vector<std::string> removed;
  for (const Log& log : logs) {
    if (used_bytes <= quota_bytes) break;
    remove(log.name);
    used_bytes -= log.bytes;
    removed.push_back(log.name);
  }
  return removed;
}

/// What stands beside a log goes with it, also when somebody removed only the log.
void MatchLogFiles::remove_orphans() const {
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path log = fs::path(entry->path()).replace_extension();
    const std::string name = log.filename().string(), kind = entry->path().extension().string();
    const bool is_ours = kind == ".index" || kind == ".pinned" || kind == ".unfinished";
    std::error_code failed;
    if (is_ours && is_match_log_name(name) && name != open_name() &&
        !fs::exists(fs::symlink_status(log, failed)))
      fs::remove(entry->path(), failed);
  }
}

void MatchLogFiles::look_after(const std::stop_token& stop) {
  const std::vector<std::string> all = names();
  remove_orphans();
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(known_, [&](const auto& one) { return std::ranges::find(all, one.first) == all.end(); });
  }
  for (const std::string& name : all) {
    if (stop.stop_requested()) return;
    if (name == open_name()) continue;
    const fs::path path = folder_ / name;
    std::error_code error;
    Known now{
        .bytes = size_of(path), .written = fs::last_write_time(path, error), .index = {}, .problem = {}};
    {
      const std::lock_guard lock(mutex_);
      const auto known = known_.find(name);
      if (known != known_.end() && known->second.bytes == now.bytes && known->second.written == now.written)
        continue;
    }
    try {
      // The service was killed while it wrote this one. Files of others stay as they are.
      if (const fs::path mark = unfinished_mark_of(path); fs::exists(mark)) {
        const RepairedMatchLog repaired = repair_match_log(path, stop);
        if (!repaired.was_whole)
          log::warning("{}: was not ended; what was on the disk of it is kept", path.string());
        remove_file(mark);
      }
      now.index = std::make_shared<const MatchLogIndex>(match_log_index(path, stop));
      now.problem = now.index->problem;
    } catch (const std::exception& failure) {
      if (stop.stop_requested()) return;
      now.problem = failure.what();
    }
    now.bytes = size_of(path);
    now.written = fs::last_write_time(path, error);
    const std::lock_guard lock(mutex_);
    known_[name] = std::move(now);
  }
}

}  // namespace sslv
