// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip.h"
#include "clips/clip_format.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace sslv {

/// Writes a clip. Each block is readable as soon as it is written, even if the clip is never finished:
/// readers of an unfinished clip rebuild the index. All functions that write throw StorageError, also for
/// data that a clip cannot hold; earlier blocks stay valid, and more blocks may be added. Used by one thread
/// at a time.
class ClipWriter {
 public:
  /// Creates the file, which must not exist yet. `max_blocks`: for tests.
  ClipWriter(const std::filesystem::path& file, const ClipAbout& about,
             std::uint64_t max_blocks = kMaxClipBlocks);
  /// Leaves an unfinished clip if finish() was not called.
  ~ClipWriter();
  ClipWriter(const ClipWriter&) = delete;
  ClipWriter& operator=(const ClipWriter&) = delete;

  /// Returns the setup's index in the clip's list of setups, for the frames that follow.
  std::uint32_t add(const ClipSetup& setup);
  /// Like add(), from the parts of a setup's payload (clip_format.h). The number in that payload is ignored.
  std::uint32_t add_setup(std::uint32_t camera_id, std::span<const std::byte> json,
                          std::span<const std::byte> table);
  /// A camera's frames must be added in processing order, after their setup. Does not copy packet, memory or
  /// image.
  void add(const ClipFrame& frame);
  void add(const ClipEvent& event);
  /// Records that the clip lacks this number of a camera's processed frames.
  void note_missing(std::uint32_t camera_id, std::uint64_t frames);

  /// Writes index and trailer, and syncs file and folder to the disk.
  void finish();

  std::uint64_t bytes() const;
  /// Whether no more frames fit, because the remaining blocks are reserved (kClipEndBlocks).
  bool is_full() const;

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace sslv
