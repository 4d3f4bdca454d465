// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_log_index.h"
#include "recording/recording_settings.h"
#include "services/event.h"

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

inline constexpr std::uint64_t kMb = 1'000'000;  // bytes, as the settings count them

/// What a clip is, without its frames.
struct ClipFacts {
  double begin_s = 0, end_s = 0;  // Unix time of the first and the last frame
  std::string why{};              // it was kept
  struct Camera {
    int id = 0;
    std::size_t frames = 0;
    std::uint64_t missing = 0;
  };
  std::vector<Camera> cameras{};
};

/// A match log or clip of the folder.
struct RecordingFile {
  enum class Kind { kMatchLog, kClip };
  std::string name;
  Kind kind = Kind::kMatchLog;
  std::uint64_t bytes = 0;
  bool is_pinned = false, is_open = false;  // open: it is being written
  // Of its kind; null while it is made, and when it cannot be.
  std::shared_ptr<const MatchLogIndex> index;
  std::shared_ptr<const ClipFacts> clip;
  std::string problem;  // why it cannot be read, or not to its end; empty when it can
};

struct DiskUse {
  std::uint64_t used_bytes = 0;  // by recordings
  std::uint64_t free_bytes = 0;  // that the service may use
};

/// Whom room is made for. Clips go before match logs, and of either what was written longest ago first. What
/// is pinned or being written stays, and so does the newest match log. Strangers may have filled that:
/// nothing goes for what it has beyond its counted share and half the quota, and a recording of more than
/// that half goes before all others.
enum class RoomFor {
  kMatchLog,    // it may exceed the quota where nothing can go for it
  kWantedClip,  // by a person, or after a crash
  kOtherClip,   // all match logs stay
};

/// What make_room() found.
struct Room {
  std::string problem{};   // why a match log exceeds the quota; empty: it does not
  bool is_scarce = false;  // strangers must take no more: the rest is for what is ours
};

/// The folder with recordings. A match log is NAME.log.gz or NAME.log, a clip NAME.clip; beside it may stand
/// a log's index (.index), a mark that it is pinned (.pinned), and one that it is not finished yet
/// (.unfinished). May be used from any thread.
class RecordingFiles {
 public:
  static constexpr const char* kFolderName = "recordings";  // in the state folder

  /// Makes the folder when the first recording is begun.
  explicit RecordingFiles(std::filesystem::path folder);

  const std::filesystem::path& folder() const { return folder_; }

  /// A path for a new one that begins now: "2026-07-03_14-05_NAME.log.gz" (UTC), with a number where there is
  /// one of that name. It is not complete until end() is called. Throws StorageError.
  std::filesystem::path begin(const std::string& name,
                              RecordingFile::Kind kind = RecordingFile::Kind::kMatchLog);
  /// `is_finished`: it needs no repairing. Throws StorageError.
  void end(const std::filesystem::path& file, bool is_finished);

  /// Those that were written last come first.
  std::vector<RecordingFile> list(RecordingFile::Kind kind) const;
  /// None: there is no such file, or its name is none of a recording.
  std::optional<RecordingFile> find(const std::string& name) const;
  std::filesystem::path path_of(const std::string& name) const { return folder_ / name; }

  /// Throw StorageError.
  void pin(const std::string& name, bool is_pinned);
  /// False: it is being written.
  bool remove(const std::string& name);

  DiskUse disk_use() const;
  /// Removes recordings until one of so many bytes more has room, and tells of each; nothing where that would
  /// not be enough. Throws StorageError where a clip would exceed the quota, or the disk must stay free.
  Room make_room(const RecordingSettings& settings, RoomFor whom, EventQueue& events,
                 std::uint64_t wanted_bytes = 0);

  /// From now on room is made for no more than this share, 0 to 1, of this log while it is the newest.
  void count(const std::string& log, double share);

  /// Makes logs whole that were not finished, and indexes that are missing. May take long. What fails is
  /// tried again, less and less often. `now_s`: on a steady clock.
  void look_after(const std::stop_token& stop, double now_s);

 private:
  struct Known {
    std::uint64_t bytes = 0;
    std::filesystem::file_time_type written;
    std::shared_ptr<const MatchLogIndex> index;
    std::shared_ptr<const ClipFacts> clip;
    std::string problem;
    double wait_s = 0;  // until it is tried again, which is at again_s
    double again_s = std::numeric_limits<double>::infinity();
  };
  struct Removable {
    std::filesystem::file_time_type written;
    std::string name;
    std::uint64_t bytes = 0;
    bool is_clip = false;
  };
  struct Removables {
    std::vector<Removable> all;         // in the order in which they go
    std::uint64_t uncounted_bytes = 0;  // of the newest log, which is none of them
  };
  Removables removable(RoomFor whom, std::uint64_t most) const;
  std::vector<std::string> names() const;
  bool is_open(const std::string& name) const;
  void look_at_log(const std::filesystem::path& path, Known& now, const std::stop_token& stop) const;
  void remove_orphans() const;

  const std::filesystem::path folder_;
  std::mutex room_mutex_;             // room is made for one at a time
  mutable std::mutex mutex_;          // guards the next ones; not held while a file is read
  std::set<std::string> open_names_;  // of those that are written
  std::map<std::string, Known> known_;
  std::string counted_log_;
  double counted_share_ = 1;
};

/// Whether a client may name such a recording: nothing but a file of the folder.
bool is_recording_name(const std::string& name);

}  // namespace sslv
