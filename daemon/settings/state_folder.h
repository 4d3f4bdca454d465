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
/// bytes: temporary file, fsync, rename, fsync of the folder. If `previous` is not empty, the old content is
/// kept in that file, which is complete at any time, too. If root writes, the folder's owner gets the file.
///
/// Throws StorageError; the file then holds its old content.
void write_file_durably(const std::filesystem::path& file, std::string_view content,
                        unsigned permissions = 0640, const std::filesystem::path& previous = {});

/// Removes a file if it exists. Throws StorageError.
void remove_file(const std::filesystem::path& file);

/// Removes temporary files that a killed write_file_durably() left for this file.
void remove_leftover(const std::filesystem::path& file);

/// Renames an unusable file to keep its content: *.rejected, or *.rejected.2 and so on if that exists.
/// Returns its new name.
std::filesystem::path set_aside(const std::filesystem::path& file);

/// The folder in which the service stores everything, and the folder's problems. The service starts and runs
/// even if the folder is unusable: only saving needs it. Thread-safe.
class StateFolder {
 public:
  /// Creates the folder if possible.
  explicit StateFolder(std::filesystem::path path);
  StateFolder(const StateFolder&) = delete;
  StateFolder& operator=(const StateFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// write_file_durably() into this folder or a folder in it, which is created if it is missing.
  void write(const std::filesystem::path& file, std::string_view content,
             const std::filesystem::path& previous = {});

  /// Why the last write failed; empty if it succeeded. Does not wait for a write in progress.
  std::string write_problem() const { return *write_problem_.load(); }

  /// Why nothing can be saved at present, in one line; empty if saving works, as far as is known without
  /// writing.
  std::string find_problem() const;

 private:
  const std::filesystem::path path_;
  Snapshot<std::string> write_problem_{""};
};

}  // namespace sslv
