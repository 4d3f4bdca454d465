// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/json.h"
#include "capture/driver_calls.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace sslv {

class StateFolder;

/// Images that somebody has sent: folders in images/ of the state folder, for the backend "files" to show.
/// Few, small and of the kinds that it reads, so that nobody can fill the disk. May be used from any thread.
class UploadedImages {
 public:
  static constexpr std::size_t kMaxImageBytes = 16 * 1024 * 1024;
  static constexpr std::size_t kMaxFolders = 20, kMaxImages = 500;  // images of a folder
  static constexpr std::uintmax_t kMaxBytes = 512 * 1024 * 1024;    // of all
  static constexpr std::int64_t kMaxPixels = 32'000'000;

  explicit UploadedImages(StateFolder& folder);

  /// Saves an image, in the place of one with the same name. On disk when it returns. Throws SettingsError
  /// with one line when it is not allowed, and StorageError.
  std::filesystem::path save(const std::string& folder, const std::string& name, std::string_view bytes);

  /// Removes a folder with its images. False when it is not there. Throws SettingsError and StorageError.
  bool remove(const std::string& folder);

  struct Folder {
    std::string name;
    std::filesystem::path path;
    std::size_t images = 0;
    std::uintmax_t bytes = 0;
  };
  /// By their names.
  std::vector<Folder> folders() const;

  /// An image that is being decoded in save() is not waited for any more: it is refused.
  void ask_to_stop() const { decoding_.ask_to_stop(); }

  /// Where a folder of this name is, or would be. Throws SettingsError for a name that is not allowed.
  std::filesystem::path path_of(const std::string& folder) const;

 private:
  void check_room(const std::filesystem::path& file, std::size_t bytes) const;
  void check_readable(const std::string& name, std::string_view bytes) const;

  StateFolder& state_;
  const std::filesystem::path path_;
  mutable std::mutex mutex_;  // held while files change
  const DriverCalls decoding_{std::chrono::minutes(1)};
};

}  // namespace sslv
