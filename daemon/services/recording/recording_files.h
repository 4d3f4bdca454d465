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

inline constexpr std::uint64_t kMb = 1'000'000;  // bytes per MB in the settings

/// Summary of a clip.
struct ClipFacts {
  double begin_s = 0, end_s = 0;  // Unix time of the first and the last frame
  std::string why{};              // why the clip was kept
  struct Camera {
    int id = 0;
    std::size_t frames = 0;
    std::uint64_t missing = 0;
  };
  std::vector<Camera> cameras{};
};

/// A match log or clip in the folder.
struct RecordingFile {
  enum class Kind { kMatchLog, kClip };
  std::string name;
  Kind kind = Kind::kMatchLog;
  std::uint64_t bytes = 0;
  bool is_pinned = false, is_open = false;  // open: it is being written
  // `index` is set for match logs, `clip` for clips. Null until the file has been read, or if it cannot be
  // read.
  std::shared_ptr<const MatchLogIndex> index;
  std::shared_ptr<const ClipFacts> clip;
  std::string problem;  // why it cannot be read completely; empty: no problem
};

struct DiskUse {
  std::uint64_t used_bytes = 0;  // bytes used by recordings
  std::uint64_t free_bytes = 0;  // free bytes of the disk that the service may use
};

/// The purpose for which make_room() frees space. make_room() removes clips before match logs, the oldest of
/// each kind first, and never pinned or open recordings or the newest match log. Strangers (see
/// MatchLogRecorder) may have filled that log: no recording is removed to make space for its bytes beyond its
/// counted share or beyond half the quota. A recording larger than half the quota is removed before all other
/// recordings.
enum class RoomFor {
  kMatchLog,  // may exceed the quota if nothing more can be removed
  kClip,      // removes no match logs
};

/// Result of make_room().
struct Room {
  std::string problem{};   // why a match log exceeds the quota; empty: it does not
  bool is_scarce = false;  // space is low: the rest is reserved for our own senders
};

/// The folder with recordings: match logs NAME.log.gz or NAME.log, clips NAME.clip. Files beside a recording:
/// the index of a log (.index), and marks for pinned (.pinned) and unfinished (.unfinished) recordings. May
/// be used from any thread.
class RecordingFiles {
 public:
  static constexpr const char* kFolderName = "recordings";  // in the state folder

  /// The folder is created with the first recording.
  explicit RecordingFiles(std::filesystem::path folder);

  const std::filesystem::path& folder() const { return folder_; }

  /// Path for a new recording that begins now: "2026-07-03_14-05_NAME.log.gz" (UTC), with a number if that
  /// name exists. The recording is unfinished until end() is called. Throws StorageError.
  std::filesystem::path begin(const std::string& name,
                              RecordingFile::Kind kind = RecordingFile::Kind::kMatchLog);
  /// `is_finished`: the recording needs no repair. Throws StorageError.
  void end(const std::filesystem::path& file, bool is_finished);

  /// Sorted by time of writing, the newest first.
  std::vector<RecordingFile> list(RecordingFile::Kind kind) const;
  /// Nullopt if there is no such file, or if it is not a recording's name.
  std::optional<RecordingFile> find(const std::string& name) const;
  std::filesystem::path path_of(const std::string& name) const { return folder_ / name; }

  /// pin() and remove() throw StorageError.
  void pin(const std::string& name, bool is_pinned);
  /// Returns false if the recording is being written.
  bool remove(const std::string& name);

  DiskUse disk_use() const;
  /// Removes recordings until `wanted_bytes` more fit, with an event for each; removes none if that cannot
  /// free enough space. Throws StorageError if a clip would exceed the quota, or the disk would have less
  /// free space than the settings require.
  Room make_room(const RecordingSettings& settings, RoomFor whom, EventQueue& events,
                 std::uint64_t wanted_bytes = 0);

  /// From now on, while `log` is the newest log, at most this share (0 to 1) of its bytes counts in
  /// make_room().
  void count(const std::string& log, double share);

  /// Repairs unfinished logs, creates missing indexes, reads clips, and removes orphaned indexes and marks.
  /// May take long. Retries failures at increasing intervals. `now_s`: on a steady clock.
  void look_after(const std::stop_token& stop, double now_s);

 private:
  struct Known {
    std::uint64_t bytes = 0;
    std::filesystem::file_time_type written;
    std::shared_ptr<const MatchLogIndex> index;
    std::shared_ptr<const ClipFacts> clip;
    std::string problem;
    double wait_s = 0;  // retry interval in s; the next try is at again_s
    double again_s = std::numeric_limits<double>::infinity();
  };
  struct Removable {
    std::filesystem::file_time_type written;
    std::string name;
    std::uint64_t bytes = 0;
    bool is_clip = false;
  };
  struct Removables {
    std::vector<Removable> all;         // in order of removal
    std::uint64_t uncounted_bytes = 0;  // bytes of the newest log (not in `all`) that do not count
  };
  Removables removable(RoomFor whom, std::uint64_t most) const;
  std::vector<std::string> names() const;
  bool is_open(const std::string& name) const;
  void look_at_log(const std::filesystem::path& path, Known& now, const std::stop_token& stop) const;
  void remove_orphans() const;

  const std::filesystem::path folder_;
  std::mutex room_mutex_;             // serializes make_room()
  mutable std::mutex mutex_;          // guards the members below; not held while a file is read
  std::set<std::string> open_names_;  // names of recordings that are being written
  std::map<std::string, Known> known_;
  std::string counted_log_;
  double counted_share_ = 1;
};

/// Whether clients may use this name: it can only name a recording in the folder, and is not a path.
bool is_recording_name(const std::string& name);

}  // namespace sslv
