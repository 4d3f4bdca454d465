// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "recording/match_log_index.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

/// A match log of the folder.
struct MatchLogFile {
  std::string name;
  std::uint64_t bytes = 0;
  bool is_pinned = false;
  std::shared_ptr<const MatchLogIndex> index;  // null while it is made, and when it cannot be
  std::string problem;  // why the log cannot be read, or not to its end; empty when it can
};

struct DiskUse {
  std::uint64_t used_bytes = 0;  // by recordings
  std::uint64_t free_bytes = 0;  // that the service may use
};

/// The folder with match logs. A log is NAME.log.gz or NAME.log; beside it may stand its index (.index), a
/// mark that it is pinned (.pinned), and one that it is not finished yet (.unfinished). May be used from any
/// thread.
class MatchLogFiles {
 public:
  /// Makes the folder when the first log is begun.
  explicit MatchLogFiles(std::filesystem::path folder);

  const std::filesystem::path& folder() const { return folder_; }

  /// A path for a new log that begins now: "2026-07-03_14-05_NAME.log.gz" (UTC), with a number where there is
  /// one of that name. It is no complete log until end() is called. Throws StorageError.
  std::filesystem::path begin(const std::string& name);
  /// `is_finished`: it needs no repairing. Throws StorageError.
  void end(bool is_finished);

  /// Those that were written last come first.
  std::vector<MatchLogFile> list() const;
  /// None: there is no such file, or its name is none of a log.
  std::optional<MatchLogFile> find(const std::string& name) const;
  std::filesystem::path path_of(const std::string& name) const { return folder_ / name; }

  /// Throw StorageError.
  void pin(const std::string& name, bool is_pinned);
  /// False: it is being written.
  bool remove(const std::string& name);

  DiskUse disk_use() const;
  /// Removes logs that are complete and not pinned, those that were written longest ago first, until
  /// recordings take no more than that. Their names. Throws StorageError.
  std::vector<std::string> make_room(std::uint64_t quota_bytes);

  /// Makes logs whole that were not finished, and indexes that are missing. May take long.
  void look_after(const std::stop_token& stop);

 private:
  struct Known {
    std::uint64_t bytes = 0;
    std::filesystem::file_time_type written;
    std::shared_ptr<const MatchLogIndex> index;
    std::string problem;
  };
  std::vector<std::string> names() const;
  std::string open_name() const;
  void remove_orphans() const;

  const std::filesystem::path folder_;
  mutable std::mutex mutex_;  // guards the next two; not held while a file is read
  std::string open_name_;     // of the log that is written
  std::map<std::string, Known> known_;
};

/// Whether a client may name such a log: nothing but a file of the folder.
bool is_match_log_name(const std::string& name);

}  // namespace sslv
