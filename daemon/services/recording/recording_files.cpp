// SPDX-License-Identifier: Apache-2.0
#include "services/recording/recording_files.h"

#include "base/error.h"
#include "base/log.h"
#include "clips/clip_reader.h"
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
/// Part of the quota and of the free disk space that clips leave to match logs.
constexpr int kReserve_mb = 400;
/// Part of the quota and of the free disk space that is reserved for messages of our own senders: slightly
/// more than strangers send between two checks (see MatchLogRecorder).
constexpr int kStrangersReserve_mb = 50;
/// Retry intervals for a recording that cannot be read.
constexpr double kFirstRetry_s = 10, kLastRetry_s = 600;
constexpr const char* kClipEnding = ".clip";

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() > end.size() && text.ends_with(end);
}

fs::path pin_of(const fs::path& log) {
  return log.string() + ".pinned";
}

fs::path unfinished_mark_of(const fs::path& log) {
  return log.string() + ".unfinished";
}

/// False for links, which could lead out of the folder.
bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::symlink_status(path, error).type() == fs::file_type::regular;
}

bool is_clip(const fs::path& file) {
  return file.extension() == kClipEnding;
}

ClipFacts facts_of(const ClipReader& clip) {
  ClipFacts out{.begin_s = clip.about().begin_s, .end_s = clip.about().end_s, .why = clip.about().why};
  if (!clip.entries().empty()) {
    out.begin_s = clip.entries().front().t_capture_s;
    out.end_s = clip.entries().back().t_capture_s;
  }
  for (const ClipReader::Camera& camera : clip.cameras())
    out.cameras.push_back({static_cast<int>(camera.id), camera.frames.size(), camera.missing});
  return out;
}

std::uint64_t size_of(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  return error ? 0 : size;
}

}  // namespace

bool is_recording_name(const std::string& name) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.' || c == ' ';
  };
  return (ends_with(name, ".log") || ends_with(name, ".log.gz") || ends_with(name, kClipEnding)) &&
         name.size() <= kMaxName && name[0] != '.' && std::ranges::all_of(name, is_allowed);
}

RecordingFiles::RecordingFiles(fs::path folder) : folder_(std::move(folder)) {}

std::vector<std::string> RecordingFiles::names() const {
  std::vector<std::string> out;
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (is_recording_name(name) && is_file(entry->path())) out.push_back(name);
  }
  return out;
}

bool RecordingFiles::is_open(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return open_names_.contains(name);
}

fs::path RecordingFiles::begin(const std::string& name, RecordingFile::Kind kind) {
  const char* const ending = kind == RecordingFile::Kind::kClip ? kClipEnding : ".log.gz";
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) throw StorageError(fmt::format("{}: cannot be created: {}", folder_.string(), error.message()));
  const std::string begin = fmt::format("{:%Y-%m-%d_%H-%M}_{}", fmt::gmtime(std::time(nullptr)), name);
  for (int number = 1; number < kMaxOfOneName; ++number) {
    const std::string file = begin + (number > 1 ? fmt::format("_{}", number) : "") + ending;
    if (fs::exists(folder_ / file, error)) continue;
    {
      const std::lock_guard lock(mutex_);
      open_names_.insert(file);
    }
    try {
      write_file_durably(unfinished_mark_of(folder_ / file), "");
    } catch (const StorageError&) {
      const std::lock_guard lock(mutex_);
      open_names_.erase(file);
      throw;
    }
    return folder_ / file;
  }
  throw StorageError(fmt::format("{}: there are too many recordings named {}", folder_.string(), begin));
}

void RecordingFiles::end(const fs::path& file, bool is_finished) {
  {
    const std::lock_guard lock(mutex_);
    open_names_.erase(file.filename().string());
  }
  if (is_finished) remove_file(unfinished_mark_of(file));
}

std::optional<RecordingFile> RecordingFiles::find(const std::string& name) const {
  if (!is_recording_name(name)) return std::nullopt;
  std::error_code error;
  const fs::path path = folder_ / name;
  if (!is_file(path)) return std::nullopt;
  RecordingFile out{.name = name,
                    .kind = is_clip(path) ? RecordingFile::Kind::kClip : RecordingFile::Kind::kMatchLog,
                    .bytes = size_of(path),
                    .is_pinned = fs::exists(pin_of(path), error),
                    .is_open = false,
                    .index = {},
                    .clip = {},
                    .problem = {}};
  const std::lock_guard lock(mutex_);
  out.is_open = open_names_.contains(name);
  if (const auto known = known_.find(name); known != known_.end() && !out.is_open) {
    out.index = known->second.index;
    out.clip = known->second.clip;
    out.problem = known->second.problem;
  }
  return out;
}

std::vector<RecordingFile> RecordingFiles::list(RecordingFile::Kind kind) const {
  std::vector<std::pair<fs::file_time_type, RecordingFile>> files;
  for (const std::string& name : names()) {
    std::error_code error;
    if (auto file = find(name); file && file->kind == kind)
      files.emplace_back(fs::last_write_time(path_of(name), error), *std::move(file));
  }
  std::ranges::sort(files, std::greater{},
                    [](const auto& file) { return std::tie(file.first, file.second.name); });
  std::vector<RecordingFile> out;
  for (auto& file : files) out.push_back(std::move(file.second));
  return out;
}

void RecordingFiles::pin(const std::string& name, bool is_pinned) {
  const fs::path pin = pin_of(folder_ / name);
  is_pinned ? write_file_durably(pin, "") : remove_file(pin);
}

bool RecordingFiles::remove(const std::string& name) {
  if (is_open(name)) return false;
  const fs::path log = folder_ / name;
  remove_file(log);
  remove_file(index_file_of(log));
  remove_file(pin_of(log));
  remove_file(unfinished_mark_of(log));
  const std::lock_guard lock(mutex_);
  known_.erase(name);
  return true;
}

DiskUse RecordingFiles::disk_use() const {
  DiskUse use;
  for (const std::string& name : names())
    use.used_bytes += size_of(folder_ / name) + size_of(index_file_of(folder_ / name));
  std::error_code error;
  fs::space_info space = fs::space(folder_, error);
  if (error) space = fs::space(folder_.parent_path(), error);  // not created yet
  if (!error) use.free_bytes = space.available;
  return use;
}

RecordingFiles::Removables RecordingFiles::removable(RoomFor whom, std::uint64_t most) const {
  // Order by time of writing, not by name: other programs save recordings here too, and the clock may have
  // been wrong.
  Removables out;
  std::pair<std::string, double> counted;
  {
    const std::lock_guard lock(mutex_);
    counted = {counted_log_, counted_share_};
  }
  fs::file_time_type newest_log = fs::file_time_type::min();
  for (const std::string& name : names()) {
    std::error_code error;
    const fs::path path = folder_ / name;
    const fs::file_time_type written = fs::last_write_time(path, error);
    const std::uint64_t bytes = size_of(path) + size_of(index_file_of(path));
    if (!is_clip(path) && written > newest_log) {
      newest_log = written;
      const double share = name == counted.first ? counted.second : 1;
      out.uncounted_bytes =
          bytes - std::min(most, static_cast<std::uint64_t>(share * static_cast<double>(bytes)));
    }
    if (!is_open(name) && !fs::exists(pin_of(path), error))
      out.all.push_back({written, name, bytes, is_clip(path)});
  }
  std::erase_if(out.all, [&](const Removable& one) {
    return !one.is_clip && (whom == RoomFor::kClip || one.written == newest_log);
  });
  std::ranges::sort(out.all, {}, [&](const Removable& one) {
    return std::tuple(one.bytes <= most, !one.is_clip, one.written, one.name);
  });
  return out;
}

void RecordingFiles::count(const std::string& log, double share) {
  const std::lock_guard lock(mutex_);
  counted_log_ = log;
  counted_share_ = share;
}

Room RecordingFiles::make_room(const RecordingSettings& settings, RoomFor whom, EventQueue& events,
                               std::uint64_t wanted_bytes) {
  const std::lock_guard one_at_a_time(room_mutex_);
  // Clips leave a reserve: they must never end a match log by filling the last space. With a small quota, the
  // reserve is small.
  const int reserve_mb = whom == RoomFor::kMatchLog ? 0 : std::min(kReserve_mb, settings.quota_mb / 4);
  const std::uint64_t quota = static_cast<std::uint64_t>(settings.quota_mb - reserve_mb) * kMb;
  const std::uint64_t keep_free =
      (static_cast<std::uint64_t>(settings.keep_free_mb) + static_cast<std::uint64_t>(reserve_mb)) * kMb;
  const std::uint64_t most = static_cast<std::uint64_t>(settings.quota_mb) * kMb / 2;
  const DiskUse use = disk_use();
  const Removables removables = removable(whom, most);
  const std::uint64_t takes = use.used_bytes + wanted_bytes;
  const std::uint64_t counted = takes - std::min(takes, removables.uncounted_bytes);
  std::uint64_t gained = 0;
  std::vector<std::string> goes;
  for (const Removable& one : removables.all) {
    const bool lacks_quota = counted - gained > quota,
               lacks_disk = use.free_bytes + gained < keep_free + wanted_bytes;
    // On a full disk, clips must not end a match log.
    if (!lacks_quota && !(lacks_disk && one.is_clip && whom == RoomFor::kMatchLog)) break;
    gained += std::min(counted - gained, one.bytes);
    goes.push_back(one.name);
  }
  if (counted - gained > quota) {  // not enough: remove nothing
    gained = 0;
    goes.clear();
  }
  const std::uint64_t reserve =
      static_cast<std::uint64_t>(std::min(kStrangersReserve_mb, settings.quota_mb / 4)) * kMb;
  Room room{.is_scarce = takes - gained + reserve > quota || use.free_bytes + gained < keep_free + reserve};
  if (takes - gained > quota)
    room.problem = fmt::format(
        "recordings {} {} MB, and may take {} MB (/recording/quota_mb); no more of them can be removed",
        wanted_bytes > 0 ? "would take" : "take", takes / kMb, quota / kMb);
  // Strangers' bytes in the newest log that count() excludes do not prevent a clip.
  if (counted - gained > quota && whom != RoomFor::kMatchLog) throw StorageError(room.problem);
  if (use.free_bytes + gained < keep_free + wanted_bytes)
    throw StorageError(
        fmt::format("{:.1f} GB of the disk are free; recordings leave {:.1f} GB (/recording/keep_free_mb){}",
                    static_cast<double>(use.free_bytes) * 1e-9, settings.keep_free_mb * 1e-3,
                    reserve_mb > 0 ? fmt::format(", clips {:.1f} GB more", reserve_mb * 1e-3) : ""));
  for (const std::string& name : goes) {
    if (!remove(name)) continue;
    log::info("recording {} was removed to make room", name);
    events.add(
        {.id = "recording_removed", .title = fmt::format("Recording {} was removed to make room", name)});
  }
  return room;
}

/// Removes indexes and marks of recordings that no longer exist.
void RecordingFiles::remove_orphans() const {
  std::error_code error;
  for (fs::directory_iterator entry(folder_, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path log = fs::path(entry->path()).replace_extension();
    const std::string name = log.filename().string(), kind = entry->path().extension().string();
    const bool is_ours = kind == ".index" || kind == ".pinned" || kind == ".unfinished";
    std::error_code failed;
    if (is_ours && is_recording_name(name) && !is_open(name) && !fs::exists(fs::symlink_status(log, failed)))
      fs::remove(entry->path(), failed);
  }
}

void RecordingFiles::look_at_log(const fs::path& path, Known& now, const std::stop_token& stop) const {
  // The mark shows that the service was killed while it wrote this log. Logs of other programs have no mark
  // and are not changed.
  if (const fs::path mark = unfinished_mark_of(path); fs::exists(mark)) {
    const RepairedMatchLog repaired = repair_match_log(path, stop);
    if (repaired.is_other) throw StorageError(fmt::format("{}: contains no intact messages", path.string()));
    if (!repaired.was_whole) log::warning("{}: was not ended; the part on disk is kept", path.string());
    remove_file(mark);
  }
  now.index = std::make_shared<const MatchLogIndex>(match_log_index(path, stop));
  now.problem = now.index->problem;
}

void RecordingFiles::look_after(const std::stop_token& stop, double now_s) {
  const std::vector<std::string> all = names();
  remove_orphans();
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(known_, [&](const auto& one) { return std::ranges::find(all, one.first) == all.end(); });
  }
  for (const std::string& name : all) {
    if (stop.stop_requested()) return;
    if (is_open(name)) continue;
    const fs::path path = folder_ / name;
    std::error_code error;
    Known now{.bytes = size_of(path),
              .written = fs::last_write_time(path, error),
              .index = {},
              .clip = {},
              .problem = {}};
    {
      const std::lock_guard lock(mutex_);
      const auto known = known_.find(name);
      if (known != known_.end() && known->second.bytes == now.bytes && known->second.written == now.written) {
        if (now_s < known->second.again_s) continue;
        now.wait_s = known->second.wait_s;
      }
    }
    try {
      if (is_clip(path)) {
        const ClipReader clip(path, stop);  // also reads unfinished clips
        now.clip = std::make_shared<const ClipFacts>(facts_of(clip));
        if (clip.is_unfinished()) now.problem = "was not ended: the part on disk is kept";
        remove_file(unfinished_mark_of(path));
      } else {
        look_at_log(path, now, stop);
      }
    } catch (const std::exception& failure) {
      if (stop.stop_requested()) return;
      now.problem = failure.what();
      // Try again: the disk may have been full, or somebody may change the permissions of the file.
      now.wait_s = std::clamp(2 * now.wait_s, kFirstRetry_s, kLastRetry_s);
      now.again_s = now_s + now.wait_s;
    }
    now.bytes = size_of(path);
    now.written = fs::last_write_time(path, error);
    const std::lock_guard lock(mutex_);
    known_[name] = std::move(now);
  }
}

}  // namespace sslv
