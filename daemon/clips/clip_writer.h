// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip.h"
#include "clips/clip_format.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace sslv {

/// Writes a clip from its beginning to its end. Every block can be read at once, also when the rest is never
/// written: who reads an unfinished clip makes the index again. Throws StorageError wherever it writes, also
/// for what a clip cannot hold; all that was added before stays, and more may be added. Used by one thread at
/// a time.
class ClipWriter {
 public:
  /// Makes the file, which must not be there yet. `max_blocks`: for tests.
  ClipWriter(const std::filesystem::path& file, const ClipAbout& about,
             std::uint64_t max_blocks = kMaxClipBlocks);
  /// Leaves an unfinished clip behind when finish() was not called.
  ~ClipWriter();
  ClipWriter(const ClipWriter&) = delete;
  ClipWriter& operator=(const ClipWriter&) = delete;

  /// Its place in the clip's list of setups, for the frames that follow.
  std::uint32_t add(const ClipSetup& setup);
  /// The same for what a setup's payload holds (clip_format.h), whatever its number.
  std::uint32_t add_setup(std::uint32_t camera_id, std::span<const std::byte> json,
                          std::span<const std::byte> table);
  /// A camera's frames come in their order, behind the setup that they name. Copies nothing that is large.
  void add(const ClipFrame& frame);
  void add(const ClipEvent& event);
  /// Frames of a camera that the clip lacks although they were processed, and why.
  void note_missing(std::uint32_t camera_id, std::uint64_t frames);

  /// Writes the index and makes sure that all is on the disk.
  void finish();

  std::uint64_t bytes() const;
  /// Frames that come now would take the room of what a clip ends with.
  bool is_full() const;

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace sslv
