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
/// and every block has a checksum. Opening a file and reading it frame by frame takes at most 64 MB of
/// memory. Used by one thread at a time.
class ClipReader {
 public:
  /// A frame in the index.
  struct Entry {
    std::uint32_t camera_id = 0, number = 0;
    double t_capture_s = 0;
    std::uint64_t place : 62 = 0;  // offset of its block in the file
    bool has_memory : 1 = false;   // has the stages' state: processing from here reproduces the live results
    bool is_whole : 1 = true;      // the frame has its image
  };
  static_assert(sizeof(Entry) == 24, "there may be many");
  struct Camera {
    std::uint32_t id = 0;
    std::vector<std::uint32_t> frames{};  // indices in entries()
    std::uint64_t missing = 0;            // processed frames that are not in the clip
  };

  /// Reads the index, or rebuilds it from the block heads if there is none. The file stays open and may be
  /// removed. Throws ClipError, also if `stop` is requested while the index is being rebuilt.
  explicit ClipReader(const std::filesystem::path& file, const std::stop_token& stop = {});
  ~ClipReader();
  ClipReader(ClipReader&&) noexcept;
  ClipReader& operator=(ClipReader&&) noexcept;

  const ClipAbout& about() const;
  /// All frames in order of capture time; each camera's frames are in processing order.
  const std::vector<Entry>& entries() const;
  /// The cameras in order of id.
  const std::vector<Camera>& cameras() const;
  const Camera* camera(std::uint32_t id) const;
  std::size_t setup_count() const;
  /// Reads the setup from the file. `about` is null if the setup is damaged or missing. Throws ClipError if
  /// the file cannot be read.
  ClipSetup setup(std::size_t number) const;
  const std::vector<ClipEvent>& events() const;
  /// Whether the clip is truncated or has no valid index. Blocks before the damage are read.
  bool is_unfinished() const;
  /// The first problem found, in one line that begins with the path; empty: none. Images and setups are only
  /// checked when they are read.
  const std::string& problem() const;

  /// Frame `place` of entries(). Its views are valid until the next call of read(). Its setup number is below
  /// setup_count(). An image that an earlier version stored in parts is left out. Throws ClipError if the
  /// frame is damaged or its image exceeds the limits (clip_format.h).
  const ClipFrame& read(std::size_t place);
  /// Like read(place), but reads the image directly into the memory that room(bytes) returns (for a camera's
  /// buffers). Rows and low bits are stored there without gaps. `room` is not called for a frame without an
  /// image, and may throw.
  const ClipFrame& read(std::size_t place, const std::function<std::uint8_t*(std::size_t bytes)>& room);

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace sslv
