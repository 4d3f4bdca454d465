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

/// Uploaded images: folders in images/ of the state folder, for the backend "files" to show. Their number,
/// size and types are limited, so that nobody can fill the disk. Thread-safe.
class UploadedImages {
 public:
  static constexpr std::size_t kMaxImageBytes = 16 * 1024 * 1024;
  static constexpr std::size_t kMaxFolders = 20, kMaxImages = 500;  // kMaxImages: per folder
  static constexpr std::uintmax_t kMaxBytes = 512 * 1024 * 1024;    // of all images together
  static constexpr std::int64_t kMaxPixels = 32'000'000;

  explicit UploadedImages(StateFolder& folder);

  /// Saves an image, replacing an image of the same name; the file is on disk on return. Returns its folder.
  /// Throws SettingsError with one line if it is not allowed, and StorageError.
  std::filesystem::path save(const std::string& folder, const std::string& name, std::string_view bytes);

  /// Removes a folder with its images. False if it does not exist. Throws SettingsError and StorageError.
  bool remove(const std::string& folder);

  struct Folder {
    std::string name;
    std::filesystem::path path;
    std::size_t images = 0;
    std::uintmax_t bytes = 0;
  };
  /// Sorted by name.
  std::vector<Folder> folders() const;

  /// Makes save() refuse an image that it is decoding, instead of waiting for the decoder.
  void ask_to_stop() const { decoding_.ask_to_stop(); }

  /// Returns the path of a folder of this name, which may not exist. Throws SettingsError for an invalid
  /// name.
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
