// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "services/backup_part.h"
#include "vision/label.h"
#include "vision/lut.h"

#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

namespace sslv {

class StateFolder;

/// Colour tables that were edited, learnt or imported: each a file tables/*.lut of the state folder, named
/// after its content, so that a name always means the same table. The settings, their history and profiles
/// keep names. May be used from any thread.
class SavedTables : public BackupPart {
 public:
  /// Beyond that the oldest that nobody uses go.
  static constexpr std::size_t kMax = 200;

  explicit SavedTables(StateFolder& folder);

  /// Its name; on disk when it returns, and whole where a damaged file was. Throws StorageError.
  std::string save(const std::shared_ptr<const Lut>& lut, const LabelSet& labels);

  /// Throws SettingsError, beginning with `path`, when there is no such table or its file cannot be used. Up
  /// to end_start() it returns null instead: a service that starts reports what it has lost, see lost().
  std::shared_ptr<const Lut> load(const std::string& name, const std::string& path,
                                  const LabelSet& labels) const;

  void end_start() noexcept { is_start_ = false; }
  /// Why a table could not be used at start; empty when it could.
  std::string lost(const std::string& name) const;

  /// Removes old ones, but none of these.
  void tidy(const std::set<std::string>& used);

  // BackupPart: all that lie there, also those that only the history and profiles name; of very many, the
  // settings' own and the newest.
  BackupFiles files(const Config& config) const override;
  bool has(const std::string& name) const override;
  std::unique_ptr<SavedWith> prepare(BackupFiles files) override;

 private:
  class Offered;
  /// Throws StorageError.
  void put_file(const std::string& name, const std::string& bytes);

  std::shared_ptr<const Lut> load_now(const std::string& name, const std::string& path,
                                      const LabelSet& labels) const;
  std::filesystem::path file_of(const std::string& name) const { return folder_ / (name + ".lut"); }

  StateFolder& state_;
  const std::filesystem::path folder_;
  mutable std::mutex mutex_;  // guards what follows
  mutable std::map<std::string, std::weak_ptr<const Lut>> in_memory_;
  mutable std::map<std::string, std::string> lost_;  // by name: why
  const BackupFiles* offered_ = nullptr;             // of a backup that is being restored
  std::atomic<bool> is_start_ = true;
};

}  // namespace sslv
