// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/error.h"
#include "base/json.h"
#include "base/snapshot.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace sslv {

/// Reads a JSON file. Throws SettingsError naming the file and, for a syntax error, line and column.
Json read_json_file(const std::filesystem::path& file);

/// Replaces a file's content so that after a power cut it holds either all of the old or all of the new
/// bytes: temporary file, fsync, rename, fsync of the folder. What it held is kept as `previous`, if named,
/// which is whole at any time too. Written by root, it belongs to whom the folder belongs to.
/// Throws StorageError; the file then holds what it held.
void write_file_durably(const std::filesystem::path& file, std::string_view content,
                        unsigned permissions = 0640, const std::filesystem::path& previous = {});

/// Removes a file, if it is there. Throws StorageError.
void remove_file(const std::filesystem::path& file);

/// Removes what a write_file_durably() that was killed has left of this file.
void remove_leftover(const std::filesystem::path& file);

/// Renames a file that cannot be used so that nothing of it is lost (*.rejected, or *.rejected.2 ... where
/// there are earlier ones); its new name.
std::filesystem::path set_aside(const std::filesystem::path& file);

/// The folder with all that the service keeps, and what is wrong with it. The service starts and runs without
/// one that can be used: only saving needs it. May be used from any thread.
class StateFolder {
 public:
  /// Makes the folder, if it can.
  explicit StateFolder(std::filesystem::path path);
  StateFolder(const StateFolder&) = delete;
  StateFolder& operator=(const StateFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// write_file_durably() into this folder or one in it, which is made when it is missing.
  void write(const std::filesystem::path& file, std::string_view content,
             const std::filesystem::path& previous = {});

  /// Why the last write failed; empty when it did not. Does not wait for one under way.
  std::string write_problem() const { return *write_problem_.load(); }

  /// Why nothing could be saved now, one line; empty when it could, as far as can be seen without writing.
  std::string find_problem() const;

 private:
  const std::filesystem::path path_;
  Snapshot<std::string> write_problem_{""};
};

}  // namespace sslv
