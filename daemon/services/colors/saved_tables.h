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

/// Colour tables that were edited, learnt or imported. Each is a file tables/*.lut in the state folder, named
/// after its content, so that a name always identifies the same table. The settings, their history and
/// profiles store names. Thread-safe.
class SavedTables : public BackupPart {
 public:
  /// Maximum number of unused tables that tidy() keeps; it removes the oldest.
  static constexpr std::size_t kMax = 200;

  explicit SavedTables(StateFolder& folder);

  /// Returns the table's name. The file is on disk when this returns; a damaged file is rewritten. Throws
  /// StorageError.
  std::string save(const std::shared_ptr<const Lut>& lut, const LabelSet& labels);

  /// Throws SettingsError with a message that begins with `path` if the table is missing or cannot be used.
  /// Before end_start(), returns null instead, and lost() returns the reason.
  std::shared_ptr<const Lut> load(const std::string& name, const std::string& path,
                                  const LabelSet& labels) const;

  void end_start() noexcept { is_start_ = false; }
  /// Why a table could not be used at start; empty if it could.
  std::string lost(const std::string& name) const;

  /// Keeps the tables in `used` and the kMax newest other tables; removes the rest.
  void tidy(const std::set<std::string>& used);

  // BackupPart: all saved tables, including tables that only the history and profiles name. If they are too
  // large together, files() returns only the settings' tables and the newest other tables.
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
  mutable std::mutex mutex_;  // guards the members below
  mutable std::map<std::string, std::weak_ptr<const Lut>> in_memory_;
  mutable std::map<std::string, std::string> lost_;  // table name -> reason
  const BackupFiles* offered_ = nullptr;             // files of a backup being restored; null: none
  std::atomic<bool> is_start_ = true;
};

}  // namespace sslv
