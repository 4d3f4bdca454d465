// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clips/clip_writer.h"
#include "services/recording/last_seconds.h"

#include <cstdint>
#include <map>
#include <optional>

namespace sslv {

/// One camera's part of a clip that is being written: writes its frames with their setups, and counts missing
/// frames.
class ClipCamera {
 public:
  /// `every_nth`: the ring stores only every n-th frame on purpose; the frames in between do not count as
  /// missing.
  ClipCamera(LastSeconds::Ring ring, int every_nth);

  ImageRing& ring() { return *from_.ring; }
  /// Bytes of all held frames and of the frames expected within `seconds`.
  double expected_bytes(double seconds) const;

  /// Writes the ring's oldest held frame and releases it. Returns false if no frame is held or if the frame
  /// was skipped: its setup is missing, or it is the first frame but not a keyframe (it lacks the saved state
  /// of the stages). Throws StorageError.
  bool write_oldest(ClipWriter& writer);
  /// The clip is over: frames that the ring drops from now on are not counted.
  void end_now();
  /// Notes frames that the ring dropped during the clip as missing. Throws StorageError.
  void note_dropped(ClipWriter& writer);

  bool has_begun() const { return last_number_.has_value(); }
  double newest_s() const { return newest_s_; }  // capture time of the newest frame, Unix
  std::uint64_t missing() const { return missing_; }

 private:
  void note_missing(ClipWriter& writer, std::uint64_t frames);

  const LastSeconds::Ring from_;
  const std::uint32_t every_nth_;
  const std::uint64_t dropped_before_;
  std::optional<std::uint64_t> dropped_at_end_;
  std::map<std::uint32_t, std::uint32_t> setups_;  // setup number in the ring -> in the clip
  std::optional<std::uint32_t> last_number_;       // number of the previous frame
  double newest_s_ = 0;
  std::uint64_t missing_ = 0;
};

}  // namespace sslv
