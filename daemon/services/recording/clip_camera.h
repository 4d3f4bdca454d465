// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip_writer.h"
#include "services/recording/last_seconds.h"

#include <cstdint>
#include <map>
#include <optional>

namespace sslv {

/// One camera's part of a clip that is written: which of the ring's frames are in it, the setups they need,
/// and what is missing.
class ClipCamera {
 public:
  /// `every_nth`: which frames were kept on purpose.
  ClipCamera(LastSeconds::Ring ring, int every_nth);

  ImageRing& ring() { return *from_.ring; }
  /// Of all frames that are held, and those to come within so many seconds.
  double expected_bytes(double seconds) const;

  /// Writes the ring's oldest held frame and lets it go. False: it is not for the clip, because what it needs
  /// is not there. Throws StorageError.
  bool write_oldest(ClipWriter& writer);
  /// Frames that find no room in the ring from now on are not of the clip.
  void end_now();
  /// Notes those that found no room before. Throws StorageError.
  void note_dropped(ClipWriter& writer);

  bool has_begun() const { return last_number_.has_value(); }
  double newest_s() const { return newest_s_; }  // when the newest of the clip was captured, Unix time
  std::uint64_t missing() const { return missing_; }

 private:
  void note_missing(ClipWriter& writer, std::uint64_t frames);

  const LastSeconds::Ring from_;
  const std::uint32_t every_nth_;
  const std::uint64_t dropped_before_;
  std::optional<std::uint64_t> dropped_at_end_;
  std::map<std::uint32_t, std::uint32_t> setups_;  // number of the camera's -> of the clip's
  std::optional<std::uint32_t> last_number_;       // of the frame before
  double newest_s_ = 0;
  std::uint64_t missing_ = 0;
};

}  // namespace sslv
