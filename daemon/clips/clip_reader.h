// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace sslv {

/// Reads a clip, finished or not. Nothing in the file is trusted: every count has a limit (clip_format.h),
/// every block a checksum. No file takes more than 64 MB of memory to be opened and looked at, frame by
/// frame. Used by one thread at a time.
class ClipReader {
 public:
  /// A frame as the index has it.
  struct Entry {
    std::uint32_t camera_id = 0, number = 0;
    double t_capture_s = 0;
    std::uint64_t place : 62 = 0;  // of its block in the file
    bool has_memory : 1 = false;   // of the stages: what is processed from here on is as it was live
    bool is_whole : 1 = true;      // the image is there
  };
  static_assert(sizeof(Entry) == 24, "there may be many");
  struct Camera {
    std::uint32_t id = 0;
    std::vector<std::uint32_t> frames{};  // places in entries()
    std::uint64_t missing = 0;            // frames that were processed and are not in the clip
  };

  /// Reads the index, or makes it when there is none, from what stands before each block. The file stays
  /// open: it may be removed. Throws ClipError, also when it is told to stop before that is done.
  explicit ClipReader(const std::filesystem::path& file, const std::stop_token& stop = {});
  ~ClipReader();
  ClipReader(ClipReader&&) noexcept;
  ClipReader& operator=(ClipReader&&) noexcept;

  const ClipAbout& about() const;
  /// In the order of their capture.
  const std::vector<Entry>& entries() const;
  /// In the order of their ids.
  const std::vector<Camera>& cameras() const;
  const Camera* camera(std::uint32_t id) const;
  std::size_t setup_count() const;
  /// Read from the file each time. One that is damaged or missing has null for its `about`. Throws ClipError
  /// where the file cannot be read.
  ClipSetup setup(std::size_t number) const;
  const std::vector<ClipEvent>& events() const;
  /// It ends in the middle, or has no index; what was read before the damage is there.
  bool is_unfinished() const;
  /// What is wrong with it, in one line that begins with the path; empty: nothing was found. Images and
  /// setups are only looked at when they are read.
  const std::string& problem() const;

  /// Frame `place` of entries(). All in it lies in this reader's memory until the next call. Its setup is
  /// below setup_count(). Of images that an earlier version kept in parts it has none. Throws ClipError when
  /// it is damaged, or its image is larger than a clip may have.
  const ClipFrame& read(std::size_t place);
  /// The same into memory of the caller's, who gets it when its size is known: the image is read there and
  /// nowhere else (for a camera's buffers). Rows and low bits lie there without gaps. `room` is not called
  /// for a frame without an image, and may throw.
  const ClipFrame& read(std::size_t place, const std::function<std::uint8_t*(std::size_t bytes)>& room);

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace sslv
